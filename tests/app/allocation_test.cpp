// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <Eigen/Core>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <lodestar/ins_solution_t.hpp>
#include <vector>

#include "level_flight.h"
#include "lodestar/app/cycle_recorder.h"
#include "lodestar/app/event_log.h"
#include "lodestar/app/reporter.h"
#include "lodestar/app/session.h"

// Counts what this thread allocates: malloc itself, because Eigen does not go through operator new.
// The sanitizers bring their own malloc; there the tests are skipped.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LODESTAR_OWN_MALLOC 0
#else
#define LODESTAR_OWN_MALLOC 1
#endif

namespace {
thread_local std::size_t allocations = 0;
}

#if LODESTAR_OWN_MALLOC
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}
}
#endif

namespace lodestar::app {
namespace {

class Allocation : public testing::Test {
 protected:
  void SetUp() override {
    if (!LODESTAR_OWN_MALLOC) GTEST_SKIP() << "the sanitizer brings its own malloc";
    spdlog::set_level(spdlog::level::off);
  }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }
};

TEST_F(Allocation, IsSeenByThisTest) {
  const std::size_t before = allocations;
  const std::vector<int> by_new(100);
  EXPECT_EQ(allocations, before + 1);
  const Eigen::MatrixXd by_eigen = Eigen::MatrixXd::Zero(by_new.size() / 10, 7);
  EXPECT_EQ(allocations, before + 2);
  EXPECT_EQ(by_eigen.size(), 70);
}

/// What flight does with each message and frame, but for the bus.
class FlightPath : public Sink {
 public:
  void receive(const Sent& message) {
    const auto* outputs =
        session_.receive(message.channel, message.bytes.data(), message.bytes.size());
    if (outputs == nullptr) return;
    cycle_.add(5e-6);
    reporter_.watch(*outputs);
    ++frames;
  }
  void send(const char*, const bus::Message& message) override { sent += message.size > 0; }
  void complete(samples::Health& health) override {
    health.cycle = cycle_.take();
    reporter_.watch(health, 0);
    ++healths;
  }
  navigator::CalibrationResult calibration() const {
    return session_.navigator().calibration_result();
  }
  int frames = 0;
  int sent = 0;
  int healths = 0;

 private:
  EventLog log_;
  Reporter reporter_{log_};
  CycleRecorder cycle_;
  Session session_{navigator::Config{}, *this};
};

TEST_F(Allocation, DoesNotHappenInTheFramePath) {
  const std::vector<Sent> flight = level_flight(10);
  FlightPath path;
  const std::size_t before = allocations;
  for (const Sent& message : flight) path.receive(message);
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(path.frames, 600);
  EXPECT_EQ(path.healths, 10);
  const int monitors = 10 * 10 + 1;  // one more when there is an attitude to compare with
  EXPECT_EQ(path.sent, 2 * path.frames + monitors + 2 * path.healths);
}

TEST_F(Allocation, DoesNotHappenWhileTheInsCalibratesTheDetector) {
  std::vector<Sent> flight;
  for (const Sent& message : level_flight(10)) {
    if (message.channel == samples::Channel::kBodyRates) {
      const double ripple = 1e-5 * std::sin(1e-5 * static_cast<double>(message.time_us));
      flight.push_back(sent(
          samples::Channel::kIns,
          ins_solution_t{
              message.time_us, ripple, 0.0, 0.08, 1.0036, 0.28, 5000.0, {200.0, 0.0, 0.0}, 1}));
    }
    flight.push_back(message);
  }
  FlightPath path;
  const std::size_t before = allocations;
  for (const Sent& message : flight) path.receive(message);
  EXPECT_EQ(allocations, before);
  EXPECT_GT(path.calibration().checks.duration, 8.0);
}

TEST_F(Allocation, DoesNotHappenWhenTheTimeBaseJumps) {
  const std::vector<Sent> late = level_flight(5, 3600);
  const std::vector<Sent> early = level_flight(5);
  FlightPath path;
  const std::size_t before = allocations;
  for (const Sent& message : late) path.receive(message);
  for (const Sent& message : early) path.receive(message);
  EXPECT_EQ(allocations, before);
  EXPECT_GT(path.frames, 300 + 250);  // the second flight was taken up, all but its first frames
}

TEST_F(Allocation, DoesNotHappenForBadMessagesEither) {
  const std::vector<Sent> flight = level_flight(10);
  std::vector<Sent> damaged = flight;
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    std::vector<std::uint8_t>& bytes = damaged[i].bytes;
    switch (i % 5) {
      case 0:
        bytes.pop_back();
        break;
      case 1:
        bytes[3] ^= 1;
        break;
      case 2:
        bytes[16] = 0x7F;  // the first value becomes NaN or huge
        bytes[17] = 0xFF;
        break;
      case 3:
        bytes[8] = 0x80;  // a time far in the past
        break;
      default:
        break;
    }
  }
  FlightPath path;
  const std::size_t before = allocations;
  for (std::size_t i = 0; i < flight.size(); ++i) {
    path.receive(damaged[i]);
    path.receive(flight[i]);
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GE(path.frames, 590);  // damaged body rates may cost a frame, the good ones go on
}

}  // namespace
}  // namespace lodestar::app
