// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CStream.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <string>

/** \file
 * Reading of MRPT objects from files that may be damaged or hostile. */

namespace mrpt::fusion {

/** What the objects of one file may cost beyond the bytes of the file. */
struct ReadingBudget {
  /** Number of octree nodes that compressed maps may unpack to, besides kNodesPerByte for each of
   * their bytes. */
  size_t nodes = 4'000'000;
  /** Number of pairs of neighbours among the edge voxels of a map, see edgePairs(). One second on
   * two cores: 1e9 pairs. */
  static constexpr uint64_t kMostEdgePairs = 2'000'000'000;
  /** Number of nodes per compressed byte. Maps of buildings have 3, synthetic maps up to 100. */
  static constexpr size_t kNodesPerByte = 128;

  /** Returns the largest number of nodes that so many compressed bytes may unpack to. */
  size_t mostNodes(size_t bytes) const { return nodes + kNodesPerByte * bytes; }
  /** Takes the nodes that compressed bytes have unpacked to. There are at most mostNodes(). */
  void take(size_t unpacked, size_t bytes) {
    nodes -= std::max(unpacked, kNodesPerByte * bytes) - kNodesPerByte * bytes;
  }
};

/** The end of reading: the file ends early, or asks for more than it may. It is a std::bad_alloc
 * because MRPT passes this exception on as it is. MRPT wraps all other exceptions once per nested
 * object, which takes milliseconds each time and hides the reason. */
class ReadingStopped : public std::bad_alloc {
 public:
  /** \param[in] reason The reason; a literal. */
  explicit ReadingStopped(const char* reason) : reason_(reason) {}
  const char* what() const noexcept override { return reason_; }

 private:
  const char* reason_;
};

/** The beginning of a serialized object. */
struct ObjectHeader {
  std::string class_name;  ///< Class of the object; "nullptr" if there is none
  bool is_old = false;     ///< True before MRPT 0.5.5: no mark at the end
  int8_t version = -1;     ///< Version of the class
};

/** An archive that reads from a stream or from another archive and bounds the nesting of objects,
 * of any class. An object that is read within another object uses the stack. So the guard bounds
 * the stack. */
class GuardedArchive : public mrpt::serialization::CArchive {
 public:
  /** Reads from a stream. The budget must outlive the archive. */
  GuardedArchive(mrpt::io::CStream& stream, ReadingBudget& budget);
  /** Reads from another archive, with its budget if it has one. */
  explicit GuardedArchive(mrpt::serialization::CArchive& in);
  ~GuardedArchive() override = default;
  GuardedArchive(const GuardedArchive&) = delete;
  GuardedArchive& operator=(const GuardedArchive&) = delete;

  ReadingBudget& budget() { return *budget_; }

  /** Reads the class of the next object, before anything of the object. */
  ObjectHeader readHeader();
  /** Reads an object after its header. \param[in,out] object The object; null if everything except
   * the mark at its end has been read. */
  void readBody(mrpt::serialization::CSerializable* object, const ObjectHeader& header);

 protected:
  size_t read(void* buffer, size_t count) override;
  size_t write(const void* buffer, size_t count) override;

 private:
  std::function<size_t(void* buffer, size_t count)> source_;
  ReadingBudget own_;
  ReadingBudget* budget_;
  const char* stack_begin_;
  bool has_begun_ = false;
};

}  // namespace mrpt::fusion
