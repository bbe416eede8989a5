// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Bounds the nesting and the cost of MRPT objects. */

#include "mrpt_fusion_maps/archives/guarded_archive.h"

#include <cstdlib>

#include "fusion_base/bits.h"

namespace mrpt::fusion {

namespace {

/** Largest stack of nested objects, bytes. Recordings need a tenth of it. */
constexpr ptrdiff_t kMostStack = ptrdiff_t{1} << 18;

}  // namespace

GuardedArchive::GuardedArchive(mrpt::io::CStream& stream, ReadingBudget& budget)
    : source_([&stream](void* buffer, size_t count) { return stream.Read(buffer, count); }),
      budget_(&budget),
      stack_begin_(stackPosition()) {}

GuardedArchive::GuardedArchive(mrpt::serialization::CArchive& in)
    : source_([&in](void* buffer, size_t count) { return in.ReadBuffer(buffer, count); }),
      budget_(&own_),
      stack_begin_(stackPosition()) {
  if (auto* guarded = dynamic_cast<GuardedArchive*>(&in)) budget_ = guarded->budget_;
}

ObjectHeader GuardedArchive::readHeader() {
  ObjectHeader header;
  internal_ReadObjectHeader(header.class_name, header.is_old, header.version);
  return header;
}

void GuardedArchive::readBody(mrpt::serialization::CSerializable* object,
                              const ObjectHeader& header) {
  internal_ReadObject(object, header.class_name, header.is_old, header.version);
}

size_t GuardedArchive::read(void* buffer, size_t count) {
  if (std::abs(stackPosition() - stack_begin_) > kMostStack)
    throw ReadingStopped("too many objects within each other");
  const size_t n = source_(buffer, count);
  if (n < count && has_begun_) throw ReadingStopped("the file ends early");
  has_begun_ = true;
  return n;
}

size_t GuardedArchive::write(const void*, size_t) {
  THROW_EXCEPTION("the archive is for reading only");
}

}  // namespace mrpt::fusion
