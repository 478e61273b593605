// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/config.h"

#include <gtest/gtest.h>

#include <string>

namespace lodestar::navigator {
namespace {

std::string complaint(const std::string& text) {
  try {
    parse_config(text, "own.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Config, EmptyTextGivesTheDefaults) {
  const Config config = parse_config("", "own.toml");
  EXPECT_EQ(config.earth.epoch_year, EarthParameters{}.epoch_year);
  EXPECT_FALSE(config.initial.heading.has_value());
}

TEST(Config, ReadsNumbersNamesVectorsAndUnits) {
  const Config config = parse_config(R"(
[earth]
epoch_year = 2012
geomagnetic_model = "wmm2025"
[initial]
heading_deg = 90
[smdu_calibration]
bias_nT = [1, -2.5, 3]
matrix = [[1, 0.1, 0], [0, 1, 0], [0, 0, 0.9]]
)",
                                     "own.toml");
  EXPECT_EQ(config.earth.epoch_year, 2012.0);
  EXPECT_EQ(config.earth.geomagnetic_model, earth::GeomagneticKind::kWmm2025);
  EXPECT_DOUBLE_EQ(config.initial.heading.value(), math::kPi / 2.0);
  EXPECT_EQ(config.smdu_calibration.bias, Eigen::Vector3d(1.0, -2.5, 3.0));
  EXPECT_EQ(config.smdu_calibration.matrix(0, 1), 0.1);
  EXPECT_EQ(config.smdu_calibration.matrix(1, 0), 0.0);
}

TEST(Config, ReadsTheIdOfTheAirframe) {
  EXPECT_EQ(parse_config("", "own.toml").airframe.id, "");
  EXPECT_EQ(parse_config("[airframe]\nid = \"39-101\"\n", "own.toml").airframe.id, "39-101");
  const std::string allowed = "must be a text of at most 31 ASCII characters";
  for (const char* value : {"39", "\"0123456789012345678901234567890123\"", "\"\u00e4\""}) {
    EXPECT_NE(complaint(std::string("[airframe]\nid = ") + value + "\n").find(allowed),
              std::string::npos)
        << value;
  }
}

TEST(Config, AnUnknownKeyIsNamedWithFileLineAndWhatIsAllowed) {
  EXPECT_EQ(complaint("\n[earth]\nepoch = 2026.0\n"),
            "own.toml:3: earth.epoch: unknown key; allowed here: epoch_year, geomagnetic_model");
}

TEST(Config, AnUnknownSectionIsNamed) {
  const std::string text = complaint("[earht]\nepoch_year = 2026.0\n");
  EXPECT_EQ(text.substr(0, text.find(';')), "own.toml:1: earht: unknown key");
  EXPECT_NE(text.find("earth, fusion, initial"), std::string::npos) << text;
  const std::string child = complaint("[fusion.casade]\nx = 1\n");
  EXPECT_EQ(child,
            "own.toml:1: fusion.casade: unknown key; allowed here: cascade, filter, integrated");
}

TEST(Config, AValueOutOfRangeIsNamedWithItsRange) {
  EXPECT_EQ(complaint("[earth]\nepoch_year = 1066\n"),
            "own.toml:2: earth.epoch_year = 1066: must lie in [1900, 2100] decimal year");
  EXPECT_EQ(complaint("[initial]\nheading_deg = nan\n").substr(0, 44),
            "own.toml:2: initial.heading_deg = nan: must ");
}

TEST(Config, AWrongTypeIsNamed) {
  EXPECT_EQ(complaint("[earth]\nepoch_year = \"now\"\n"),
            "own.toml:2: earth.epoch_year = 'now': must be a number in [1900, 2100] decimal year");
  EXPECT_EQ(complaint("[earth]\ngeomagnetic_model = \"egm\"\n"),
            "own.toml:2: earth.geomagnetic_model = 'egm': must be one of igrf14, wmm2025");
  EXPECT_EQ(complaint("[smdu_calibration]\nbias_nT = [1, 2]\n"),
            "own.toml:2: smdu_calibration.bias_nT = [ 1, 2 ]: must be an array of 3");
  EXPECT_EQ(complaint("earth = 3\n"), "own.toml:1: earth: must be a table: [earth]");
}

TEST(Config, BadSyntaxIsNamedWithItsLine) {
  EXPECT_EQ(complaint("[earth]\nepoch_year == 3\n").substr(0, 12), "own.toml:2: ");
}

TEST(Config, TheHashTellsTextsApart) {
  EXPECT_NE(parse_config("[earth]\n", "a").hash, parse_config("[earth] \n", "a").hash);
}

TEST(Config, ACalibrationFileHoldsNothingElse) {
  Config config;
  apply_calibration(config, "[smdu_calibration]\nbias_nT = [1, 2, 3]\n", "smdu.toml");
  EXPECT_EQ(config.smdu_calibration.bias.z(), 3.0);
  EXPECT_NE(calibration_id(config.smdu_calibration), 0u);
  EXPECT_EQ(calibration_id(sahrs::FieldCalibration{}), 0u);
  EXPECT_THROW(apply_calibration(config, "[earth]\nepoch_year = 2026\n", "smdu.toml"), ConfigError);
  EXPECT_THROW(apply_calibration(config, "", "smdu.toml"), ConfigError);
}

TEST(Config, TheParameterTableHasARowForEveryKey) {
  const std::string table = parameter_table();
  EXPECT_NE(table.find("| `initial` | `heading_deg` | unset | deg | -180 … 360 |"),
            std::string::npos);
  EXPECT_NE(table.find("| `earth` | `geomagnetic_model` | `igrf14` |"), std::string::npos);
  EXPECT_NE(table.find("| `smdu_calibration` | `matrix` | [[1, 0, 0], [0, 1, 0], [0, 0, 1]] |"),
            std::string::npos)
      << table;
}

}  // namespace
}  // namespace lodestar::navigator
