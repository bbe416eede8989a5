// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Keeps the sources of a fused map, and computes what a change touches. */
#include "fusion_team/ledger/ledger.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_octree/resampling.h"
#include "fusion_team/ledger/fused_blocks.h"

namespace mrpt::fusion {
namespace {
using octomap::OcTree;
using Pose = std::optional<Eigen::Isometry3d>;

void checkFinite(const Pose& pose) {
  if (pose && !pose->matrix().allFinite())
    throw std::invalid_argument("the pose of a source is not finite");
}

bool samePose(const Pose& a, const Pose& b) {
  return a.has_value() == b.has_value() && (!a || a->matrix() == b->matrix());
}

bool isIdentity(const Pose& pose) {
  return pose->matrix() == Eigen::Isometry3d::Identity().matrix();
}

bool sameModel(const OcTreeAccess::SensorModel& a, const OcTreeAccess::SensorModel& b) {
  return a.clamp_min == b.clamp_min && a.clamp_max == b.clamp_max && a.hit == b.hit &&
         a.miss == b.miss && a.occupancy_threshold == b.occupancy_threshold;
}

}  // namespace

AddResult Ledger::add(Source source, const Pose& T_fused_source) {
  checkFinite(T_fused_source);
  const SourceName name = source.name();
  const Version version{source.sequence(), source.contentHash()};
  const auto removed = removed_.find(name);
  if (removed != removed_.end() && version.sequence <= removed->second) return AddResult::Older;
  const auto held = slots_.find(name);
  const bool is_new = held == slots_.end();
  if (!is_new) {
    const Version now{held->second.source.sequence(), held->second.source.contentHash()};
    if (version < now) return AddResult::Older;
    if (!(now < version)) return AddResult::Duplicate;
    slots_.erase(held);
  }
  const bool is_known = std::any_of(slots_.begin(), slots_.end(), [&](const auto& s) {
    return s.second.source.contentHash() == version.content_hash;
  });
  slots_.emplace(name, Slot{std::move(source), T_fused_source, nullptr, false, false});
  if (is_known && !params_.independent) return AddResult::SameContent;
  return is_new ? AddResult::Added : AddResult::Replaced;
}

bool Ledger::remove(const SourceName& name) {
  const auto held = slots_.find(name);
  return held != slots_.end() && remove(name, held->second.source.sequence());
}

bool Ledger::remove(const SourceName& name, uint64_t up_to_sequence) {
  uint64_t& removed = removed_.emplace(name, up_to_sequence).first->second;
  removed = std::max(removed, up_to_sequence);
  const auto held = slots_.find(name);
  if (held == slots_.end() || held->second.source.sequence() > up_to_sequence) return false;
  slots_.erase(held);
  return true;
}

bool Ledger::move(const SourceName& name, const Pose& T_fused_source) {
  checkFinite(T_fused_source);
  const auto held = slots_.find(name);
  if (held == slots_.end()) return false;
  Slot& slot = held->second;
  if (samePose(slot.pose, T_fused_source)) return true;
  slot.pose = T_fused_source;
  slot.on_grid = nullptr;
  return true;
}

bool Ledger::holds(const SourceName& name, const std::shared_ptr<const OcTree>& map,
                   Sources parts) const {
  const auto held = slots_.find(name);
  if (held == slots_.end() || held->second.source.map() != map) return false;
  for (SourceId& part : parts)
    if (part.content_hash == 0) part.content_hash = held->second.source.contentHash();
  return held->second.source.parts() == parts;
}

std::vector<std::pair<SourceName, Share>> Ledger::shares() const {
  std::vector<std::pair<SourceName, Share>> shares;
  std::vector<const Sources*> sources;
  for (const auto& [name, slot] : slots_)
    if (slot.pose) {
      shares.emplace_back(name, Share());
      sources.push_back(&slot.source.parts());
    }
  if (params_.independent) return shares;
  const std::vector<Share> found = sharesOf(sources);
  for (size_t i = 0; i < shares.size(); i++) shares[i].second = found[i];
  return shares;
}

std::vector<LedgerEntry> Ledger::entries() const {
  std::vector<LedgerEntry> all;
  const auto placed = shares();
  auto share = placed.begin();
  for (const auto& [name, slot] : slots_) {
    all.push_back({slot.source, slot.pose, Counting::None, std::nullopt});
    if (!slot.pose) continue;
    all.back().counting = share->second.counting;
    if (share->second.with) all.back().with = placed[*share->second.with].first;
    ++share;
  }
  return all;
}

void Ledger::putOnGrid(const std::vector<Slot*>& slots) const {
  const double resolution = slots.front()->source.map()->getResolution();
  const bool is_as_it_came = isIdentity(slots.front()->pose);
  tbb::parallel_for(size_t{0}, slots.size(), [&](size_t i) {
    Slot& slot = *slots[i];
    const bool is_resampled = i > 0 || !is_as_it_came;
    if (slot.on_grid && slot.is_resampled == is_resampled &&
        slot.on_grid->getResolution() == resolution)
      return;
    withPath(slot.source.name().robot, [&] {
      slot.on_grid = is_resampled ? transformOcTree(*slot.source.map(), *slot.pose, resolution)
                                  : slot.source.map();
      slot.is_resampled = is_resampled;
    });
  });
}

std::shared_ptr<const OcTree> Ledger::map() {
  std::vector<Slot*> slots;
  std::vector<bool> counts;
  for (auto& [name, slot] : slots_) slot.in_use = false;
  for (const auto& [name, share] : shares()) {
    if (share.counting == Counting::None || share.counting == Counting::Copy) continue;
    slots.push_back(&slots_.at(name));
    slots.back()->in_use = true;
    counts.push_back(share.counting == Counting::All);
  }
  for (auto& [name, slot] : slots_)  // bounds the memory
    if (!slot.in_use) slot.on_grid = nullptr;
  if (slots.empty()) {
    fused_ = nullptr;
    fused_from_.clear();
    return fused_;
  }
  putOnGrid(slots);

  const OcTree& first = *slots.front()->source.map();
  const auto model = OcTreeAccess::sensorModel(first);
  Parts parts{Order{params_.reference}};
  std::vector<std::shared_ptr<const OcTree>> in_order, filling;
  for (size_t i = 0; i < slots.size(); i++) {
    parts.emplace(slots[i]->source.name(), Part{slots[i]->on_grid, counts[i]});
    (counts[i] ? in_order : filling).push_back(slots[i]->on_grid);
  }
  const size_t counting = in_order.size();
  in_order.insert(in_order.end(), filling.begin(), filling.end());
  TouchedSpace touched;
  if (!fused_ || fused_->getResolution() != first.getResolution() ||
      !sameModel(OcTreeAccess::sensorModel(*fused_), model)) {
    touched.addAll();
  } else {
    const auto addDifference = [&touched](const Parts& some, const Parts& others) {
      for (const auto& [name, part] : some) {
        const auto other = others.find(name);
        if (other == others.end() || other->second != part) touched.add(*part.octree);
      }
    };
    addDifference(fused_from_, parts);
    addDifference(parts, fused_from_);
  }
  touched.finish();
  if (touched.empty() && fused_) {
    fused_from_ = std::move(parts);
    return fused_;
  }
  const OcTree none(first.getResolution());
  fused_ =
      combineOcTrees(in_order, counting, params_.merge, model, fused_ ? *fused_ : none, touched);
  fused_from_ = std::move(parts);
  return fused_;
}

}  // namespace mrpt::fusion
