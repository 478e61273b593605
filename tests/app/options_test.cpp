// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/options.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lodestar/app/calibration.h"
#include "lodestar/storage/calibration_file.h"

namespace lodestar::app {
namespace {

using testing::internal::CaptureStderr;
using testing::internal::CaptureStdout;
using testing::internal::GetCapturedStderr;
using testing::internal::GetCapturedStdout;

std::variant<Options, int> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "lodestar-fc");
  return parse_options(static_cast<int>(arguments.size()), arguments.data());
}

TEST(Options, KeepTheBusOnTheHostUnlessAPersonSaysOtherwise) {
  unsetenv("LCM_DEFAULT_URL");
  EXPECT_EQ(std::get<Options>(parse({})).lcm_url, "udpm://239.255.76.67:7667?ttl=0");
  setenv("LCM_DEFAULT_URL", "udpm://239.255.1.1:7000?ttl=0", 1);
  EXPECT_EQ(std::get<Options>(parse({})).lcm_url, "udpm://239.255.1.1:7000?ttl=0");
  EXPECT_EQ(std::get<Options>(parse({"--lcm-url", "memq://"})).lcm_url, "memq://");
  unsetenv("LCM_DEFAULT_URL");
}

TEST(Options, SayInOneLineWhatIsWrong) {
  for (const auto& arguments : std::vector<std::vector<const char*>>{
           {"--unknown"},
           {"--config"},
           {"--replay", "a.lcm"},
           {"--output", "b.lcm"},
           {"--replay", "a.lcm", "--output", "b.lcm", "--realtime"}}) {
    CaptureStderr();
    const auto result = parse(arguments);
    const std::string error = GetCapturedStderr();
    EXPECT_EQ(std::get<int>(result), 2) << arguments[0];
    EXPECT_EQ(error.rfind("lodestar-fc: ", 0), 0u) << error;
    EXPECT_EQ(error.find('\n'), error.size() - 1) << error;
  }
}

TEST(Options, PrintVersionHelpAndParametersAndEnd) {
  for (const char* option : {"--version", "--help", "--parameters"}) {
    CaptureStdout();
    const auto result = parse({option});
    const std::string printed = GetCapturedStdout();
    EXPECT_EQ(std::get<int>(result), 0) << option;
    EXPECT_FALSE(printed.empty()) << option;
  }
  CaptureStdout();
  parse({"--parameters"});
  EXPECT_NE(GetCapturedStdout().find("epoch_year"), std::string::npos);
}

class Files : public testing::Test {
 protected:
  std::string write(const char* name, const char* text) {
    paths_.push_back(testing::TempDir() + name);
    std::ofstream(paths_.back()) << text;
    return paths_.back();
  }
  ~Files() override {
    for (const std::string& path : paths_) std::filesystem::remove(path);
  }

 private:
  std::vector<std::string> paths_;
};

std::string error_of(const Options& options) {
  try {
    load_config(options);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_F(Files, OfConfigurationAndCalibrationAreRead) {
  Options options;
  options.config = write("lodestar_options.toml", "[earth]\nepoch_year = 2027.25\n");
  options.calibration =
      write("lodestar_calibration.toml", "[smdu_calibration]\nbias_nT = [10.0, 20.0, 30.0]\n");
  const navigator::Config config = load_config(options);
  EXPECT_EQ(config.earth.epoch_year, 2027.25);
  EXPECT_EQ(config.smdu_calibration.bias, Eigen::Vector3d(10.0, 20.0, 30.0));
}

/// What an earlier flight of the aircraft without a name has stored.
sahrs::smdu::Record stored(double bias) {
  sahrs::smdu::Record record;
  record.calibration.x(0) = bias;
  record.calibration.P.diagonal().setConstant(1e-6);
  return record;
}

TEST_F(Files, OfAStoredCalibrationAreUsedFromTheNextFlightOn) {
  const std::string path = write("lodestar_stored.cal", "");
  std::filesystem::remove(path);
  Options options;
  options.calibration = path;
  EXPECT_TRUE(load_config(options).smdu_calibration.bias.isZero(0.0));  // not there yet
  keep_calibration({sahrs::smdu::Verdict::kTooShort, {}, stored(10.0)}, path);
  EXPECT_FALSE(std::filesystem::exists(path));
  keep_calibration({sahrs::smdu::Verdict::kGood, {}, stored(20.0)}, path);
  EXPECT_EQ(load_config(options).smdu_calibration.bias.x(), 20.0);
  EXPECT_TRUE(load_config(options).smdu_calibration.bias_sigma);
  options.config = write("lodestar_airframe.toml", "[airframe]\nid = \"39-102\"\n");
  EXPECT_EQ(error_of(options), path + ": of another airframe than '39-102'");
}

TEST_F(Files, OfATextAreAPersonsOwn) {
  const char* text = "[smdu_calibration]\nbias_nT = [10.0, 20.0, 30.0]\n";
  const std::string path = write("lodestar_own.toml", text);
  keep_calibration({sahrs::smdu::Verdict::kGood, {}, stored(20.0)}, path);
  EXPECT_EQ(storage::read_file(path), text);
  Options options;
  options.calibration = "/no/such/smdu.toml";
  EXPECT_EQ(error_of(options), "cannot read /no/such/smdu.toml: No such file or directory");
  options.calibration = "/no/such/smdu.cal";
  EXPECT_EQ(error_of(options), "cannot store a calibration in /no/such: No such file or directory");
}

TEST_F(Files, MayBeEmpty) {
  Options options;
  options.config = write("lodestar_empty.toml", "");
  EXPECT_EQ(load_config(options).earth.epoch_year, navigator::Config{}.earth.epoch_year);
}

TEST_F(Files, ThatCannotBeReadOrUnderstoodAreNamed) {
  Options options;
  options.config = "/no/such/lodestar.toml";
  EXPECT_EQ(error_of(options), "cannot read /no/such/lodestar.toml: No such file or directory");
  options.config = testing::TempDir();
  EXPECT_NE(error_of(options).find("cannot read " + testing::TempDir()), std::string::npos);
  options.config = write("lodestar_bad.toml", "[earth]\nepoch_yaer = 2027.25\n");
  EXPECT_NE(error_of(options).find("lodestar_bad.toml"), std::string::npos);
  EXPECT_NE(error_of(options).find("epoch_yaer"), std::string::npos);
}

}  // namespace
}  // namespace lodestar::app
