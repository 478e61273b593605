// SPDX-License-Identifier: Apache-2.0
#include "lodestar/storage/calibration_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

namespace lodestar::storage {
namespace {

using sahrs::smdu::Record;

/// A record that says its number in every place.
Record record(int number, const std::string& airframe = "39-101") {
  Record r;
  r.airframe = airframe;
  r.time_us = number;
  r.epoch_year = 2026.5;
  r.calibration.x.setConstant(1e-6 * number);
  r.calibration.P.diagonal().setConstant(1.0 + number);
  return r;
}

class CalibrationFile : public testing::Test {
 protected:
  CalibrationFile() {
    folder_ = testing::TempDir() + "lodestar_calibration_XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = folder_ + "/smdu.cal";
  }
  ~CalibrationFile() override { std::filesystem::remove_all(folder_); }

  std::int64_t loaded() const { return load_calibration(path_, "39-101").record.value().time_us; }
  std::string note() const { return load_calibration(path_, "39-101").note; }
  std::string error() const {
    try {
      load_calibration(path_, "39-101");
    } catch (const StorageError& e) {
      return e.what();
    }
    return "";
  }
  void flip_a_bit(const std::string& path) const {
    std::string bytes = read_file(path).value();
    bytes[100] = static_cast<char>(bytes[100] ^ 4);
    std::ofstream(path, std::ios::binary) << bytes;
  }

  std::string folder_;
  std::string path_;
};

TEST_F(CalibrationFile, IsNotThereBeforeTheFirstFlight) {
  const LoadedCalibration loaded = load_calibration(path_, "39-101");
  EXPECT_FALSE(loaded.record);
  EXPECT_EQ(loaded.note, path_ + ": not there yet; the SMDU is not calibrated in this flight");
}

TEST_F(CalibrationFile, KeepsTheOneBefore) {
  store_calibration(path_, record(1));
  EXPECT_FALSE(std::filesystem::exists(path_ + ".previous"));
  store_calibration(path_, record(2));
  store_calibration(path_, record(3));
  EXPECT_EQ(loaded(), 3);
  EXPECT_EQ(note(), "");
  std::filesystem::remove(path_);
  EXPECT_EQ(loaded(), 2);
  EXPECT_EQ(note(), path_ + ": missing; the previous one is used, " + path_ + ".previous");
}

TEST_F(CalibrationFile, ThatIsRefusedIsNamedAndThePreviousOneUsed) {
  store_calibration(path_, record(1));
  store_calibration(path_, record(2));
  flip_a_bit(path_);
  EXPECT_EQ(loaded(), 1);
  EXPECT_EQ(note(), path_ + ": damaged: its checksum is wrong; the previous one is used, " + path_ +
                        ".previous");
  std::ofstream(path_, std::ios::binary) << encode(record(3, "39-102"));
  EXPECT_EQ(loaded(), 1);
  EXPECT_EQ(note(), path_ + ": of another airframe than '39-101'; the previous one is used, " +
                        path_ + ".previous");
  std::ofstream(path_, std::ios::binary) << encode(record(3)).substr(0, 500);
  EXPECT_EQ(loaded(), 1);
}

TEST_F(CalibrationFile, ThatIsRefusedNeverTakesThePlaceOfAGoodOne) {
  store_calibration(path_, record(1));
  store_calibration(path_, record(2));
  flip_a_bit(path_);
  store_calibration(path_, record(3));
  EXPECT_EQ(loaded(), 3);
  EXPECT_TRUE(std::filesystem::exists(path_ + ".refused"));
  std::filesystem::remove(path_);
  EXPECT_EQ(loaded(), 1);
}

TEST_F(CalibrationFile, WithNothingGoodBesideItIsAnError) {
  store_calibration(path_, record(1));
  flip_a_bit(path_);
  EXPECT_EQ(error(), path_ + ": damaged: its checksum is wrong");
  std::ofstream(path_ + ".previous", std::ios::binary) << encode(record(3, "39-102"));
  EXPECT_EQ(error(), path_ + ": damaged: its checksum is wrong; " + path_ +
                         ".previous: of another airframe than '39-101'");
}

TEST_F(CalibrationFile, ThatCannotBeWrittenIsNamedAndLeavesTheOldOne) {
  const std::string nowhere = folder_ + "/none/smdu.cal";
  EXPECT_THROW(store_calibration(nowhere, record(1)), StorageError);
  EXPECT_THROW(require_writable(nowhere), StorageError);
  require_writable(path_);
  store_calibration(path_, record(1));
  std::filesystem::create_directory(path_ + ".part");  // in the way of the temporary file
  EXPECT_THROW(store_calibration(path_, record(2)), StorageError);
  EXPECT_EQ(loaded(), 1);
}

TEST_F(CalibrationFile, IsToldFromText) {
  EXPECT_TRUE(looks_like_calibration(encode(record(1))));
  EXPECT_FALSE(looks_like_calibration("[smdu_calibration]\nbias_nT = [1, 2, 3]\n"));
  EXPECT_FALSE(looks_like_calibration(""));
}

/// Stores one calibration after the other, and says on `report` which is done, until it is killed.
[[noreturn]] void store_for_ever(const std::string& path, int first, int report) {
  for (int number = first;; ++number) {
    try {
      store_calibration(path, record(number));
    } catch (...) {
      _exit(3);
    }
    if (write(report, &number, sizeof number) != sizeof number) _exit(4);
  }
}

TEST_F(CalibrationFile, SurvivesAKillAtAnyMomentOfASave) {
  std::mt19937_64 random(7);
  int last = 0;  // the last number that is known to have been stored
  store_calibration(path_, record(last));
  int during = 0;
  for (int kill_number = 0; kill_number < 100; ++kill_number) {
    int report[2];
    ASSERT_EQ(pipe(report), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      close(report[0]);
      store_for_ever(path_, last + 1, report[1]);
    }
    close(report[1]);
    int number = last;  // once it has begun, at any moment of what follows
    ASSERT_EQ(read(report[0], &number, sizeof number), ssize_t{sizeof number});
    last = number;
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << WEXITSTATUS(status);
    while (read(report[0], &number, sizeof number) == ssize_t{sizeof number}) last = number;
    close(report[0]);
    if (std::filesystem::exists(path_ + ".part") ||
        std::filesystem::exists(path_ + ".previous.part")) {
      ++during;
    }
    const LoadedCalibration after = load_calibration(path_, "39-101");
    ASSERT_TRUE(after.record) << kill_number;
    EXPECT_EQ(after.note, "");
    const auto found = static_cast<int>(after.record->time_us);
    EXPECT_TRUE(found == last || found == last + 1) << found << " after " << last;
    EXPECT_EQ(encode(*after.record), encode(record(found)));
    last = found;
  }
  EXPECT_GT(during, 0);  // kills in the midst of a save
}

}  // namespace
}  // namespace lodestar::storage
