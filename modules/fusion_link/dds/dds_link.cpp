// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The link over DDS, by CycloneDDS. */
#include "fusion_link/dds_link.h"

#include <dds/dds.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "map_sample.h"

namespace mrpt::fusion {
namespace {

using WireSample = mrpt_fusion_msg_dds__MapSample_;

/** As ROS 2 names the topic "mrpt_fusion/map_samples". */
constexpr const char* kTopic = "rt/mrpt_fusion/map_samples";
/** Keys that a reader keeps: bounds its memory. */
constexpr int32_t kMostKeys = 100'000;
/** Time for which a write waits while the link is busy. Each attempt costs a message. */
constexpr dds_duration_t kMostBlocking = DDS_SECS(1);

/** Time for which a robot that leaves waits until the others have what it sent last. */
constexpr std::chrono::seconds kFarewell{3};

/** Returns an entity. \exception std::runtime_error If it is an error. */
dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0)
    throw std::runtime_error(std::string("DDS: ") + what + ": " + dds_strretcode(-entity));
  return entity;
}

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
      "<SPDPInterval>8s</SPDPInterval><LeaseDuration>12s</LeaseDuration>"
      "<Peers>" +
      peers +
      "</Peers></Discovery>"
      "<Internal><NackDelay>1s</NackDelay><HeartbeatInterval min=\"1s\" minsched=\"1s\" max=\"8s\">1s</HeartbeatInterval>"
      "<Watermarks><WhcHigh>8kB</WhcHigh><WhcHighInit>8kB</WhcHighInit><WhcLow>4kB</WhcLow>"
      "<WhcAdaptive>false</WhcAdaptive></Watermarks></Internal></Domain>";
  if (const char* more = std::getenv("CYCLONEDDS_URI"); more && *more)
    config += std::string(",") + more;
  return config;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

/** The latest sample of each key, for all robots, also for robots that come later. */
Qos qosOfSamples() {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMostBlocking);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

/** Fills a sample for the wire. It refers to the memory of \a key and \a bytes. */
WireSample wireSample(const SampleKey& key, uint64_t version, const std::string& bytes) {
  WireSample wire{};
  const auto copy = [](const std::string& name, char(&to)[kMostNameCharacters + 1]) {
    to[name.copy(to, kMostNameCharacters)] = '\0';
  };
  copy(key.source.robot, wire.robot);
  copy(key.source.map, wire.map_name);
  wire.kind = static_cast<uint8_t>(key.kind);
  wire.number = key.number;
  wire.version = version;
  wire.bytes._length = wire.bytes._maximum = static_cast<uint32_t>(bytes.size());
  wire.bytes._buffer = reinterpret_cast<uint8_t*>(const_cast<char*>(bytes.data()));
  return wire;
}

/** Writes samples in a thread of its own: a writer waits while too much is not acknowledged. */
class SampleWriter {
 public:
  explicit SampleWriter(dds_entity_t writer) : writer_(writer), thread_([this] { run(); }) {}
  SampleWriter(const SampleWriter&) = delete;
  SampleWriter& operator=(const SampleWriter&) = delete;
  /** Returns when the others have what was sent, or after kFarewell. */
  ~SampleWriter() {
    const auto end = std::chrono::steady_clock::now() + kFarewell;
    {
      const std::lock_guard lock(mutex_);
      end_ = end;
    }
    changed_.notify_one();
    thread_.join();
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    if (left.count() > 0) dds_wait_for_acks(writer_, left.count());
  }

  /** Takes a sample. \return False if the last one waits still. */
  bool write(const Sample& sample) {
    if (isBusy()) return false;
    put({sample, false});
    return true;
  }
  void forget(const SampleKey& key) { put({{key, 0, {}}, true}); }

 private:
  struct Task {
    Sample sample;
    bool is_obsolete;
  };

  bool isBusy() {
    const std::lock_guard lock(mutex_);
    checked(failure_, "write");
    return !tasks_.empty();
  }
  void put(Task task) {
    {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(task));
    }
    changed_.notify_one();
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return end_ || !tasks_.empty(); });
      if (tasks_.empty() || (end_ && std::chrono::steady_clock::now() > *end_)) return;
      const Task& task = tasks_.front();  // put() leaves references valid
      lock.unlock();
      const dds_return_t done = perform(task);
      lock.lock();
      if (done == DDS_RETCODE_TIMEOUT) continue;
      failure_ = std::min(failure_, done);
      tasks_.pop_front();
    }
  }
  dds_return_t perform(const Task& task) const {
    const Sample& s = task.sample;
    const WireSample wire = wireSample(s.key, s.version, s.bytes);
    return task.is_obsolete ? dds_dispose(writer_, &wire) : dds_write(writer_, &wire);
  }

  dds_entity_t writer_;
  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  dds_return_t failure_ = DDS_RETCODE_OK;
  std::optional<std::chrono::steady_clock::time_point> end_;
  std::thread thread_;  // the last member: it uses the others
};

class DdsLink : public Link {
 public:
  explicit DdsLink(const DdsSettings& settings)
      : domain_(checked(dds_create_domain(settings.domain, configOf(settings).c_str()), "domain")) {
    try {
      open(settings.domain);
    } catch (...) {
      dds_delete(domain_);
      throw;
    }
  }
  DdsLink(const DdsLink&) = delete;
  DdsLink& operator=(const DdsLink&) = delete;
  ~DdsLink() override {
    samples_.reset();
    dds_delete(domain_);
  }

  bool send(const Sample& sample) override {
    // Samples that wait here can still be put in order, and do not leave all at once.
    dds_publication_matched_status_t readers{};
    dds_get_publication_matched_status(writer_, &readers);
    return readers.current_count > 0 && samples_->write(sample);
  }

  void forget(const SampleKey& key) override { samples_->forget(key); }

  std::vector<Sample> receive(size_t most) override {
    constexpr size_t kAtATime = 64;
    std::vector<Sample> samples;
    while (samples.size() < most) {
      void* wires[kAtATime] = {};
      dds_sample_info_t infos[kAtATime];
      const size_t wanted = std::min(kAtATime, most - samples.size());
      const dds_return_t n =
          checked(dds_take(reader_, wires, infos, wanted, static_cast<uint32_t>(wanted)), "read");
      for (dds_return_t i = 0; i < n; i++)
        if (infos[i].valid_data) samples.push_back(sampleOf(*static_cast<WireSample*>(wires[i])));
      if (n > 0) dds_return_loan(reader_, wires, n);
      if (static_cast<size_t>(n) < wanted) break;
    }
    return samples;
  }

  void wait(std::chrono::milliseconds most) override {
    dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(most.count()));
  }

 private:
  void open(uint32_t domain) {
    const dds_entity_t participant =
        checked(dds_create_participant(domain, nullptr, nullptr), "participant");
    const Qos qos = qosOfSamples();
    const dds_entity_t topic =
        checked(dds_create_topic(participant, &mrpt_fusion_msg_dds__MapSample__desc, kTopic,
                                 qos.get(), nullptr),
                "topic");
    // A writer that keeps the last sample only never waits for acknowledgements in CycloneDDS. What
    // robots that come later get is in the durability service.
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
    writer_ = checked(dds_create_writer(participant, topic, qos.get(), nullptr), "writer");
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
    dds_qset_resource_limits(qos.get(), DDS_LENGTH_UNLIMITED, kMostKeys, DDS_LENGTH_UNLIMITED);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    reader_ = checked(dds_create_reader(participant, topic, qos.get(), nullptr), "reader");
    waitset_ = checked(dds_create_waitset(participant), "waitset");
    const dds_entity_t arrived =
        checked(dds_create_readcondition(reader_, DDS_ANY_STATE), "condition");
    checked(dds_waitset_attach(waitset_, arrived, 0), "waitset");
    samples_ = std::make_unique<SampleWriter>(writer_);
  }

  static Sample sampleOf(const WireSample& wire) {
    Sample sample;
    sample.key = {{wire.robot, wire.map_name}, static_cast<SampleKind>(wire.kind), wire.number};
    sample.version = wire.version;
    sample.bytes.assign(reinterpret_cast<const char*>(wire.bytes._buffer), wire.bytes._length);
    return sample;
  }

  dds_entity_t domain_, writer_ = 0, reader_ = 0, waitset_ = 0;
  std::unique_ptr<SampleWriter> samples_;
};

}  // namespace
}  // namespace mrpt::fusion

extern "C" __attribute__((visibility("default"))) mrpt::fusion::Link* openDdsLink(
    const mrpt::fusion::DdsSettings& settings) {
  return new mrpt::fusion::DdsLink(settings);
}
