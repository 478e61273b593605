// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/event_log.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>

#include "lodestar/app/reporter.h"

namespace lodestar::app {
namespace {

/// The default logger writes into a string while this lives.
class CapturedLog {
 public:
  CapturedLog() : saved_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("captured", sink));
    spdlog::set_pattern("%v");
  }
  ~CapturedLog() { spdlog::set_default_logger(saved_); }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> saved_;
};

long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

TEST(EventLog, WritesEveryEventInOrderBeforeItEnds) {
  const CapturedLog captured;
  {
    EventLog log;
    for (int i = 1; i <= 100; ++i) log.note({Event::Kind::kUnsent, 0, 0, 0, i});
    EXPECT_EQ(log.dropped(), 0);
  }
  EXPECT_EQ(lines(captured.text()), 100);
  EXPECT_LT(captured.text().find(" 1 messages"), captured.text().find(" 100 messages"));
}

TEST(EventLog, DropsAndCountsWhatDoesNotFitAndWritesTheRest) {
  const CapturedLog captured;
  constexpr int kEvents = 100'000;  // the writer cannot keep up with a bare loop
  std::int64_t dropped = 0;
  {
    EventLog log;
    for (int i = 0; i < kEvents; ++i) log.note({});
    dropped = log.dropped();
  }
  EXPECT_GT(dropped, 0);
  EXPECT_EQ(lines(captured.text()) + dropped, kEvents);
}

TEST(EventLog, SpeaksOfChannelsModesAndReasonsByName) {
  EXPECT_EQ(describe({Event::Kind::kSahrsMode, 1'500'000, 3, 0, 0}), "t=1.500 s SAHRS: coasting");
  EXPECT_EQ(describe({Event::Kind::kFusionMode, 0, 2, 0, 0}), "t=0.000 s NAV: dead reckoning");
  EXPECT_EQ(describe({Event::Kind::kRejected, 0, 5, 3, 7}),
            "t=0.000 s GPS: 7 rejected: not finite");
}

TEST(Reporter, NotesAChangeOfModeOnce) {
  const CapturedLog captured;
  {
    EventLog log;
    Reporter reporter(log);
    navigator::Outputs outputs;
    reporter.watch(outputs);
    outputs.sahrs.mode = samples::AttitudeMode::kRunning;
    reporter.watch(outputs);
    reporter.watch(outputs);
    outputs.nav.mode = samples::FusionMode::kAiding;
    reporter.watch(outputs);
  }
  EXPECT_EQ(captured.text(), "t=0.000 s SAHRS: running\nt=0.000 s NAV: aiding\n");
}

TEST(Reporter, NotesTheVerdictOnTheInsAndNotEveryDoubt) {
  const CapturedLog captured;
  {
    EventLog log;
    Reporter reporter(log);
    navigator::Outputs outputs;
    using samples::InsState;
    for (const InsState state : {InsState::kAgree, InsState::kSuspect, InsState::kAgree,
                                 InsState::kSuspect, InsState::kMiscompare, InsState::kNone}) {
      outputs.ins_monitor.state = state;
      reporter.watch(outputs);
    }
  }
  EXPECT_EQ(captured.text(),
            "t=0.000 s INS: agrees with SAHRS\n"
            "t=0.000 s INS: miscompare with SAHRS\n"
            "t=0.000 s INS: none to watch\n");
}

TEST(Reporter, SaysOnceThatTheGeomagneticModelIsLeft) {
  const CapturedLog captured;
  {
    EventLog log;
    Reporter reporter(log);
    samples::Health health;
    reporter.watch(health, 0);
    health.warning = samples::kWarningFieldModel | samples::kWarningRealtime;
    reporter.watch(health, 0);
    reporter.watch(health, 0);
  }
  EXPECT_EQ(captured.text(), "t=0.000 s outside the geomagnetic model's validity\n");
}

TEST(Reporter, NotesOnlyTheRejectionsThatAreNew) {
  const CapturedLog captured;
  {
    EventLog log;
    Reporter reporter(log);
    samples::Health health;
    auto& smdu = of(health.counters, samples::Channel::kMagneticField);
    smdu.reject(samples::Reason::kStuck);
    reporter.watch(health, 0);
    reporter.watch(health, 0);
    smdu.reject(samples::Reason::kStuck);
    smdu.reject(samples::Reason::kStuck);
    reporter.watch(health, 4);
  }
  EXPECT_EQ(captured.text(),
            "t=0.000 s SMDU: 1 rejected: stuck\n"
            "t=0.000 s SMDU: 2 rejected: stuck\n"
            "t=0.000 s 4 messages could not be sent\n");
}

}  // namespace
}  // namespace lodestar::app
