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

uint64_t markOf(const SampleKey& key, uint64_t version) {
  uint64_t mark = 0;
  for (const uint64_t value : {static_cast<uint64_t>(key.kind), key.number, version}) {
    mark = (mark ^ value) * 0x9e3779b97f4a7c15ULL;  // multiplication and shift mix all bits
    mark ^= mark >> 29U;
  }
  return mark;
}

std::string toBytes(const Holdings& holdings) {
  std::string out;
  appendValue(holdings.complete, out);
  appendValue(holdings.highest, out);
  appendValue(holdings.session, out);
  appendValue(static_cast<uint8_t>(holdings.asks), out);
  for (const uint64_t mark : holdings.marks)
    if (out.size() + sizeof(mark) <= kMostSampleBytes) appendValue(mark, out);
  return out;
}

Holdings holdingsOf(std::string_view bytes) {
  ByteReader in(bytes);
  Holdings holdings;
  holdings.complete = in.take<uint64_t>();
  holdings.highest = in.take<uint64_t>();
  holdings.session = in.take<uint64_t>();
  holdings.asks = in.take<uint8_t>() != 0;
  while (in.size() > 0) holdings.marks.insert(in.take<uint64_t>());
  return holdings;
}

std::string toBytes(const WantedBlocks& wanted) {
  std::string out;
  appendValue(static_cast<uint8_t>(wanted.no_others), out);
  for (const BlockCode code : wanted.blocks)
    if (out.size() + sizeof(code) <= kMostSampleBytes) appendValue(code, out);
  return out;
}

WantedBlocks wantedBlocksOf(std::string_view bytes) {
  WantedBlocks wanted;
  ByteReader in(bytes);
  wanted.no_others = in.take<uint8_t>() != 0;
  while (in.size() > 0) wanted.blocks.push_back(in.take<BlockCode>());
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
  if (kind > static_cast<uint8_t>(SampleKind::Claim))
    corrupt("a sample is corrupt: it is of no known kind");
  sample.key.kind = static_cast<SampleKind>(kind);
  sample.key.number = in.take<uint64_t>();
  sample.version = in.take<uint64_t>();
  if (in.size() > kMostSampleBytes) corrupt("a sample is too large");
  sample.bytes = in.takeBytes(in.size());
  return sample;
}

bool addTo(std::string& message, const Sample& sample, size_t most) {
  const std::string bytes = toBytes(sample);
  if (message.size() + sizeof(uint16_t) + bytes.size() > most) return false;
  appendValue(static_cast<uint16_t>(bytes.size()), message);
  message += bytes;
  return true;
}

std::vector<Sample> samplesOf(std::string_view message) {
  std::vector<Sample> samples;
  for (ByteReader in(message); in.size() > 0;)
    samples.push_back(sampleOf(in.takeBytes(in.take<uint16_t>())));
  return samples;
}

}  // namespace mrpt::fusion
