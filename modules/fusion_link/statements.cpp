// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes and reads what robots say, and samples. */
#include "fusion_link/statements.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"

namespace mrpt::fusion {
namespace {

void appendName(const std::string& name, std::string& out) {
  appendValue(static_cast<uint8_t>(name.size()), out);
  out += name;
}

void appendSource(const SourceName& source, std::string& out) {
  appendName(source.robot, out);
  appendName(source.map, out);
}

std::string takeName(ByteReader& in) {
  const std::string name(in.takeBytes(in.take<uint8_t>()));
  if (!isName(name)) corrupt("a sample is corrupt: a name is not allowed");
  return name;
}

SourceName takeSource(ByteReader& in) {
  std::string robot = takeName(in);
  return {std::move(robot), takeName(in)};
}

}  // namespace

bool isName(std::string_view name) {
  return name.size() <= kMostNameCharacters && std::none_of(name.begin(), name.end(), [](char c) {
           return static_cast<unsigned char>(c) < ' ' || c == 0x7F;
         });
}

std::string toBytes(const std::vector<HeldVersion>& held) {
  std::string out;
  for (const HeldVersion& h : held) {
    std::string entry;
    appendSource(h.source, entry);
    appendValue(h.complete, entry);
    appendValue(h.highest, entry);
    if (out.size() + entry.size() <= kMostSampleBytes) out += entry;
  }
  return out;
}

std::vector<HeldVersion> heldVersionsOf(std::string_view bytes) {
  std::vector<HeldVersion> held;
  for (ByteReader in(bytes); in.size() > 0;) {
    HeldVersion& h = held.emplace_back();
    h.source = takeSource(in);
    h.complete = in.take<uint64_t>();
    h.highest = in.take<uint64_t>();
  }
  return held;
}

std::string toBytes(const std::vector<WantedBlocks>& wanted) {
  std::string out;
  for (const WantedBlocks& w : wanted) {
    std::string entry;
    appendSource(w.source, entry);
    const size_t head = out.size() + entry.size() + sizeof(uint16_t);
    if (head > kMostSampleBytes) break;
    const size_t count = std::min(w.blocks.size(), (kMostSampleBytes - head) / sizeof(BlockCode));
    appendValue(static_cast<uint16_t>(count), entry);
    for (size_t i = 0; i < count; i++) appendValue(w.blocks[i], entry);
    out += entry;
  }
  return out;
}

std::vector<WantedBlocks> wantedBlocksOf(std::string_view bytes) {
  std::vector<WantedBlocks> wanted;
  for (ByteReader in(bytes); in.size() > 0;) {
    WantedBlocks& w = wanted.emplace_back();
    w.source = takeSource(in);
    const auto count = in.take<uint16_t>();
    for (unsigned i = 0; i < count; i++) w.blocks.push_back(in.take<BlockCode>());
  }
  return wanted;
}

std::string toBytes(const Sample& sample) {
  std::string out;
  appendSource(sample.key.source, out);
  appendValue(sample.key.kind, out);
  appendValue(sample.key.number, out);
  appendValue(sample.version, out);
  return out + sample.bytes;
}

Sample sampleOf(std::string_view bytes) {
  ByteReader in(bytes);
  Sample sample;
  sample.key.source = takeSource(in);
  const auto kind = in.take<uint8_t>();
  if (kind > static_cast<uint8_t>(SampleKind::Block))
    corrupt("a sample is corrupt: it is of no known kind");
  sample.key.kind = static_cast<SampleKind>(kind);
  sample.key.number = in.take<uint64_t>();
  sample.version = in.take<uint64_t>();
  if (in.size() > kMostSampleBytes) corrupt("a sample is too large");
  sample.bytes = in.takeBytes(in.size());
  return sample;
}

}  // namespace mrpt::fusion
