// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The link over DDS, by CycloneDDS. */
#include "fusion_link/dds_link.h"

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>

#include "fusion_link/dds/dds_tools.h"
#include "fusion_link/dds/message_writer.h"
#include "map_message.h"

namespace mrpt::fusion {
namespace {

/** As ROS 2 names the topic "mrpt_fusion/map_messages". */
constexpr const char* kTopic = "rt/mrpt_fusion/map_messages";
/** Messages that a reader keeps: bounds its memory. Others wait at the robot that sends them. */
constexpr int32_t kMostMessages = 256;
/** Robots that are there at a time: bounds the number of threads. */
constexpr size_t kMostRobots = 64;
/** Time for which a write waits while the link is busy. Each attempt costs a message. */
constexpr dds_duration_t kMostBlocking = DDS_SECS(1);
/** Time for which a robot that leaves waits until the others have what it sent last. */
constexpr std::chrono::seconds kFarewell{3};

void checkAddress(const std::string& address) {
  const bool is_valid = !address.empty() && std::all_of(address.begin(), address.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string(".:%-[]").find(c) != std::string::npos;
  });
  if (!is_valid) throw std::runtime_error("a peer is no address of a robot");
}

/** Returns the settings of CycloneDDS.
 *
 * Messages fit into one packet: if a packet is lost, only this message must be sent again. Little
 * is sent ahead of its acknowledgement, so that what is most wanted can go first. A robot that
 * comes back is found again within seconds. */
std::string configOf(const DdsSettings& settings) {
  std::string peers;
  for (const std::string& peer : settings.peers) {
    checkAddress(peer);
    peers += "<Peer Address=\"" + peer + "\"/>";
  }
  std::string config =
      "<Domain Id=\"any\"><General><AllowMulticast>" +
      std::string(settings.peers.empty() ? "spdp" : "false") +
      "</AllowMulticast><MaxMessageSize>1452B</MaxMessageSize>"
      "<FragmentSize>1344B</FragmentSize></General>"
      "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>4</MaxAutoParticipantIndex>"
      "<SPDPInterval>10s</SPDPInterval><LeaseDuration>12s</LeaseDuration>"
      "<Peers>" +
      peers +
      "</Peers></Discovery>"
      "<Internal><NackDelay>1s</NackDelay><HeartbeatInterval min=\"1s\" minsched=\"1s\" "
      "max=\"8s\">1s</HeartbeatInterval>"
      "<Watermarks><WhcHigh>9kB</WhcHigh><WhcHighInit>9kB</WhcHighInit><WhcLow>8300B</WhcLow>"
      "<WhcAdaptive>false</WhcAdaptive></Watermarks></Internal></Domain>";
  if (const char* more = std::getenv("CYCLONEDDS_URI"); more && *more)
    config += std::string(",") + more;
  return config;
}

/** Messages arrive as long as a session lasts. A writer that keeps the last message only would not
 * wait for acknowledgements. */
Qos qosOfMessages() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMostBlocking);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  return qos;
}

/** Returns a name for the reader of this process: each session is a partition. */
std::string randomName() {
  std::random_device random;
  return std::to_string(random()) + "-" + std::to_string(random());
}

/** The reader of a robot, as DDS describes it. */
struct Listener {
  std::string robot;      // its name
  std::string partition;  // in which it listens
};

Listener listenerOf(const dds_builtintopic_endpoint_t& endpoint) {
  Listener listener;
  void* name = nullptr;
  size_t size = 0;
  if (dds_qget_userdata(endpoint.qos, &name, &size) && name)
    listener.robot.assign(static_cast<const char*>(name), size);
  dds_free(name);
  uint32_t count = 0;
  char** partitions = nullptr;
  if (dds_qget_partition(endpoint.qos, &count, &partitions) && count == 1)
    listener.partition = partitions[0];
  for (uint32_t i = 0; i < count; i++) dds_free(partitions[i]);
  dds_free(partitions);
  return listener;
}

class DdsLink : public Link {
 public:
  explicit DdsLink(const DdsSettings& settings)
      : domain_(checked(dds_create_domain(settings.domain, configOf(settings).c_str()), "domain")) {
    try {
      open(settings);
    } catch (...) {
      dds_delete(domain_);
      throw;
    }
  }
  DdsLink(const DdsLink&) = delete;
  DdsLink& operator=(const DdsLink&) = delete;
  ~DdsLink() override {
    const auto end = std::chrono::steady_clock::now() + kFarewell;
    for (auto& session : sessions_) session.second.writer.flush(end);
    sessions_.clear();
    dds_delete(domain_);
  }

  std::map<std::string, uint64_t> sessions() override {
    findRobots();
    std::map<std::string, uint64_t> numbers;  // of two robots with one name, the later
    for (const auto& session : sessions_) {
      uint64_t& number = numbers[session.second.robot];
      number = std::max(number, session.second.number);
    }
    return numbers;
  }

  bool send(const std::string& robot, const std::string& message) override {
    Session* latest = nullptr;
    for (auto& [key, session] : sessions_)
      if (session.robot == robot && (!latest || latest->number < session.number)) latest = &session;
    return latest && latest->writer.write(message);
  }

  std::vector<std::string> receive(size_t most) override {
    std::vector<std::string> messages;
    forEachTaken(reader_, most, [&](const void* taken, const dds_sample_info_t& info) {
      const auto& bytes = static_cast<const mrpt_fusion_msg_dds__MapMessage_*>(taken)->bytes;
      if (info.valid_data)
        messages.emplace_back(reinterpret_cast<const char*>(bytes._buffer), bytes._length);
    });
    return messages;
  }

  void wait(std::chrono::milliseconds most) override {
    dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(most.count()));
  }

 private:
  using Key = std::array<uint8_t, sizeof(dds_guid_t)>;

  struct Session {
    Session(std::string name, uint64_t n, dds_entity_t to)
        : robot(std::move(name)), number(n), writer(to) {}
    std::string robot;
    uint64_t number;
    MessageWriter writer;
  };

  void open(const DdsSettings& settings) {
    participant_ =
        checked(dds_create_participant(settings.domain, nullptr, nullptr), "participant");
    const Qos qos = qosOfMessages();
    topic_ = checked(dds_create_topic(participant_, &mrpt_fusion_msg_dds__MapMessage__desc, kTopic,
                                      qos.get(), nullptr),
                     "topic");
    waitset_ = checked(dds_create_waitset(participant_), "waitset");
    robots_ = checked(
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
        "reader of robots");
    dds_qset_userdata(qos.get(), settings.robot.data(), settings.robot.size());
    dds_qset_partition1(qos.get(), partition_.c_str());
    dds_qset_resource_limits(qos.get(), kMostMessages, 1, kMostMessages);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    reader_ = checked(dds_create_reader(participant_, topic_, qos.get(), nullptr), "reader");
    for (const dds_entity_t reader : {robots_, reader_}) {
      const dds_entity_t arrived =
          checked(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
      checked(dds_waitset_attach(waitset_, arrived, 0), "waitset");
    }
  }

  template <class F>
  static void forEachTaken(dds_entity_t reader, size_t most, F&& f) {
    constexpr size_t kAtATime = 64;
    while (most > 0) {
      void* taken[kAtATime] = {};
      dds_sample_info_t infos[kAtATime];
      const size_t wanted = std::min(kAtATime, most);
      const dds_return_t n =
          checked(dds_take(reader, taken, infos, wanted, static_cast<uint32_t>(wanted)), "read");
      for (dds_return_t i = 0; i < n; i++) f(taken[i], infos[i]);
      if (n > 0) dds_return_loan(reader, taken, n);
      if (static_cast<size_t>(n) < wanted) return;
      most -= wanted;
    }
  }

  /** Begins and ends sessions as robots come and go. */
  void findRobots() {
    forEachTaken(robots_, kMostMessages, [&](const void* taken, const dds_sample_info_t& info) {
      const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(taken);
      Key key;
      std::memcpy(key.data(), endpoint.key.v, key.size());
      sessions_.erase(key);  // a robot that went and came back has a new session
      if (info.instance_state != DDS_ALIVE_INSTANCE_STATE || !info.valid_data) return;
      if (std::strcmp(endpoint.topic_name, kTopic) != 0) return;
      const Listener listener = listenerOf(endpoint);
      if (listener.partition.empty() || listener.partition == partition_) return;
      if (sessions_.size() < kMostRobots) begin(key, listener);
    });
  }

  void begin(const Key& key, const Listener& listener) {
    const Qos qos = qosOfMessages();
    dds_qset_partition1(qos.get(), listener.partition.c_str());
    const dds_entity_t writer =
        checked(dds_create_writer(participant_, topic_, qos.get(), nullptr), "writer");
    sessions_.try_emplace(key, listener.robot, ++last_number_, writer);
  }

  const std::string partition_ = randomName();
  dds_entity_t domain_, participant_ = 0, topic_ = 0, reader_ = 0, robots_ = 0, waitset_ = 0;
  std::map<Key, Session> sessions_;  // by the key of the robot's reader
  uint64_t last_number_ = 0;
};

}  // namespace
}  // namespace mrpt::fusion

extern "C" __attribute__((visibility("default"))) mrpt::fusion::Link* openDdsLink(
    const mrpt::fusion::DdsSettings& settings) {
  return new mrpt::fusion::DdsLink(settings);
}
