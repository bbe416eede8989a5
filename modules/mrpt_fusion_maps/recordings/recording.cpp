// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * A recording that is read once. */

#include "mrpt_fusion_maps/recordings/recording.h"

#include <tbb/parallel_pipeline.h>

#include <exception>
#include <memory>
#include <utility>

using mrpt::serialization::CSerializable;

namespace mrpt::fusion {
namespace {

/** The next object of a file, or why it cannot be read. */
struct NextObject {
  CSerializable::Ptr object;
  std::exception_ptr error;
};

/** Calls \a f for each object of a file. The next objects are read meanwhile. An error comes after
 * the objects before it, as without threads. */
void readAndUse(const std::string& file, const std::function<void(const CSerializable&)>& f) {
  constexpr size_t kMostAhead = 4;  // a scan may have many megabytes
  ObjectReader reader(file);
  bool ended = false;
  const auto read = [&](tbb::flow_control& control) {
    auto next = std::make_shared<NextObject>();
    if (ended) {
      control.stop();
      return next;
    }
    try {
      next->object = reader.next();
    } catch (...) {
      next->error = std::current_exception();
    }
    ended = !next->object;
    return next;
  };
  const auto use = [&](const std::shared_ptr<NextObject>& next) {
    if (next->error) std::rethrow_exception(next->error);
    if (next->object) f(*next->object);
  };
  tbb::parallel_pipeline(kMostAhead, tbb::make_filter<void, std::shared_ptr<NextObject>>(
                                         tbb::filter_mode::serial_in_order, read) &
                                         tbb::make_filter<std::shared_ptr<NextObject>, void>(
                                             tbb::filter_mode::serial_in_order, use));
}

}  // namespace

Recording::Recording(std::string path, ObjectReader& reader, CSerializable::Ptr first,
                     uint64_t most_kept_bytes)
    : file_(std::move(path)) {
  for (auto object = std::move(first); object; object = reader.next()) {
    add(object);
    all_kept_ = all_kept_ && reader.bytes() <= most_kept_bytes;
    if (all_kept_)
      objects_.push_back(std::move(object));
    else
      objects_.clear();
  }
  path_.finish();
}

void Recording::add(const CSerializable::Ptr& object) {
  path_.add(*object);
  maps_.add(object);
}

void Recording::forEachObject(const std::function<void(const CSerializable&)>& f) {
  if (!all_kept_) return readAndUse(file_, f);
  for (auto& object : objects_) {
    f(*object);
    object.reset();  // it may have loaded an external file
  }
}

}  // namespace mrpt::fusion
