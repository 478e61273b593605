// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/config.h"

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <type_traits>

#include "lodestar/math/crc32.h"

namespace lodestar::navigator {
namespace {

/// Where a complaint belongs: "gripen.toml:12: ".
std::string place(const std::string& source, const toml::source_region& region) {
  return source + ":" + std::to_string(region.begin.line) + ": ";
}

template <class Strings>
std::string joined(const Strings& strings) {
  std::string text;
  for (const std::string& s : strings) text += (text.empty() ? "" : ", ") + s;
  return text;
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(10);
  out << value;
  return out.str();
}

std::string range(const math::Parameter& p) {
  return "[" + number(p.min) + ", " + number(p.max) + "] " + p.unit;
}

std::vector<std::string> choices(const math::Choice& choice) {
  return {choice.names, choice.names + choice.count};
}

/// Reads one table into one parameter struct: visits its declaration, then refuses what is left.
class SectionReader {
 public:
  SectionReader(const toml::table& table, std::string section, const std::string& source)
      : table_(table), section_(std::move(section)), source_(source) {}

  void operator()(double& member, const math::Parameter& p) {
    if (const toml::node* node = find(p.key)) member = scaled(*node, p, p.key);
  }

  void operator()(std::optional<double>& member, const math::Parameter& p) {
    if (const toml::node* node = find(p.key)) member = scaled(*node, p, p.key);
  }

  void operator()(int& member, const math::Parameter& p) {
    const toml::node* node = find(p.key);
    if (node == nullptr) return;
    if (!node->is_integer()) complain(*node, p.key, "must be an integer in " + range(p));
    member = static_cast<int>(scaled(*node, p, p.key));
  }

  void operator()(bool& member, const math::Parameter& p) {
    const toml::node* node = find(p.key);
    if (node == nullptr) return;
    if (!node->is_boolean()) complain(*node, p.key, "must be true or false");
    member = node->value<bool>().value();
  }

  void operator()(std::string& member, const math::Text& text) {
    const toml::node* node = find(text.key);
    if (node == nullptr) return;
    const std::optional<std::string> value = node->value<std::string>();
    const auto printable = [](char c) { return c >= ' ' && c <= '~'; };
    if (!node->is_string() || value->size() > text.longest ||
        !std::all_of(value->begin(), value->end(), printable)) {
      complain(*node, text.key,
               "must be a text of at most " + std::to_string(text.longest) + " ASCII characters");
    }
    member = *value;
  }

  template <int Rows, int Columns>
  void operator()(Eigen::Matrix<double, Rows, Columns>& member, const math::Parameter& p) {
    if (const toml::node* node = find(p.key)) read_matrix(member, *node, p);
  }

  template <class Enum, class = std::enable_if_t<std::is_enum_v<Enum>>>
  void operator()(Enum& member, const math::Choice& choice) {
    const toml::node* node = find(choice.key);
    if (node == nullptr) return;
    const std::string name = node->value<std::string>().value_or("");
    for (std::size_t i = 0; i < choice.count; ++i) {
      if (name == choice.names[i]) {
        member = static_cast<Enum>(i);
        return;
      }
    }
    complain(*node, choice.key, "must be one of " + joined(choices(choice)));
  }

  /// Complains of the first key that no declaration asked for. `children` are its subsections.
  void refuse_unknown(const std::set<std::string>& children = {}) const {
    for (const auto& [key, node] : table_) {
      const std::string name(key.str());
      if (known_.count(name) != 0 || children.count(name) != 0) continue;
      std::set<std::string> allowed = known_;
      allowed.insert(children.begin(), children.end());
      throw ConfigError(place(source_, key.source()) + path(name) +
                        ": unknown key; allowed here: " + joined(allowed));
    }
  }

 private:
  const toml::node* find(const char* key) {
    known_.insert(key);
    return table_.get(key);
  }

  std::string path(const std::string& key) const {
    return section_.empty() ? key : section_ + "." + key;
  }

  [[noreturn]] void complain(const toml::node& node, const std::string& key,
                             const std::string& what) const {
    std::ostringstream value;
    node.visit([&value](const auto& typed) { value << typed; });
    throw ConfigError(place(source_, node.source()) + path(key) + " = " + value.str() + ": " +
                      what);
  }

  double scaled(const toml::node& node, const math::Parameter& p, const std::string& key) const {
    if (!node.is_number()) complain(node, key, "must be a number in " + range(p));
    const double value = node.value<double>().value();
    if (!(value >= p.min && value <= p.max)) complain(node, key, "must lie in " + range(p));
    return value * p.scale;
  }

  template <int Rows, int Columns>
  void read_matrix(Eigen::Matrix<double, Rows, Columns>& member, const toml::node& node,
                   const math::Parameter& p) const {
    const toml::array* rows = node.as_array();
    if (rows == nullptr || rows->size() != Rows) {
      complain(node, p.key, "must be an array of " + std::to_string(Rows));
    }
    for (int i = 0; i < Rows; ++i) {
      const toml::node& row = *rows->get(static_cast<std::size_t>(i));
      if constexpr (Columns == 1) {
        member(i, 0) = scaled(row, p, p.key);
      } else {
        const toml::array* cells = row.as_array();
        if (cells == nullptr || cells->size() != Columns) {
          complain(row, p.key, "must be an array of " + std::to_string(Columns));
        }
        for (int j = 0; j < Columns; ++j) {
          member(i, j) = scaled(*cells->get(static_cast<std::size_t>(j)), p, p.key);
        }
      }
    }
  }

  const toml::table& table_;
  std::string section_;
  const std::string& source_;
  std::set<std::string> known_;
};

toml::table parse_toml(std::string_view text, const std::string& source) {
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    throw ConfigError(place(source, error.source()) + std::string(error.description()));
  }
}

/// The subtable `name` of `parent`, or null; complains if it is something else.
const toml::table* subtable(const toml::table& parent, const std::string& name,
                            const std::string& source) {
  const toml::node* node = parent.get(name);
  if (node == nullptr) return nullptr;
  if (!node->is_table()) {
    throw ConfigError(place(source, node->source()) + name + ": must be a table: [" + name + "]");
  }
  return node->as_table();
}

/// "top.child" as its two parts; the second may be empty.
std::pair<std::string, std::string> split(const std::string& name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos) return {name, ""};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

/// The top-level tables of a configuration, and the subtables of each.
std::map<std::string, std::set<std::string>> subsections() {
  std::map<std::string, std::set<std::string>> sections;
  const Config defaults;
  Config::describe(defaults, [&sections](const std::string& name, const auto&) {
    const auto [top, child] = split(name);
    std::set<std::string>& children = sections[top];
    if (!child.empty()) children.insert(child);
  });
  return sections;
}

/// One row of the parameter table per parameter.
struct TableWriter {
  std::ostringstream& out;
  std::string section;

  void row(const char* key, const std::string& value, const std::string& unit,
           const std::string& allowed, const char* summary) const {
    out << "| `" << section << "` | `" << key << "` | " << value << " | " << unit << " | "
        << allowed << " | " << summary << " |\n";
  }
  void numeric(const math::Parameter& p, const std::string& value) const {
    row(p.key, value, p.unit, number(p.min) + " … " + number(p.max), p.summary);
  }
  void operator()(const double& member, const math::Parameter& p) const {
    numeric(p, number(member / p.scale));
  }
  void operator()(const std::optional<double>& member, const math::Parameter& p) const {
    numeric(p, member ? number(*member / p.scale) : "unset");
  }
  void operator()(const int& member, const math::Parameter& p) const {
    numeric(p, std::to_string(member));
  }
  void operator()(const std::string& member, const math::Text& text) const {
    row(text.key, member.empty() ? "empty" : "`" + member + "`", "-",
        "at most " + std::to_string(text.longest) + " characters", text.summary);
  }
  void operator()(const bool& member, const math::Parameter& p) const {
    row(p.key, member ? "true" : "false", p.unit, "true, false", p.summary);
  }
  template <int Rows, int Columns>
  void operator()(const Eigen::Matrix<double, Rows, Columns>& member,
                  const math::Parameter& p) const {
    const Eigen::IOFormat format(10, Eigen::DontAlignCols, ", ", ", ", "[", "]", "[", "]");
    const Eigen::Matrix<double, Rows, Columns> value = member / p.scale;
    std::ostringstream text;
    if constexpr (Columns == 1) {
      text << value.transpose().format(
          Eigen::IOFormat(10, Eigen::DontAlignCols, ", ", "", "", "", "[", "]"));
    } else {
      text << value.format(format);
    }
    numeric(p, text.str());
  }
  template <class Enum, class = std::enable_if_t<std::is_enum_v<Enum>>>
  void operator()(const Enum& member, const math::Choice& choice) const {
    row(choice.key, std::string("`") + choice.names[static_cast<std::size_t>(member)] + "`", "-",
        joined(choices(choice)), choice.summary);
  }
};

}  // namespace

Config parse_config(std::string_view text, const std::string& source) {
  const toml::table root = parse_toml(text, source);
  Config config;
  config.hash = math::crc32(text);
  const std::map<std::string, std::set<std::string>> sections = subsections();
  std::set<std::string> read;
  Config::describe(config, [&](const std::string& name, auto& parameters) {
    using Parameters = std::decay_t<decltype(parameters)>;
    read.insert(name);
    const auto [top, child] = split(name);
    const toml::table* table = subtable(root, top, source);
    if (table != nullptr && !child.empty()) table = subtable(*table, child, source);
    if (table == nullptr) return;
    SectionReader reader(*table, name, source);
    Parameters::describe(parameters, reader);
    reader.refuse_unknown(child.empty() ? sections.at(top) : std::set<std::string>{});
  });
  std::set<std::string> tops;
  for (const auto& [top, children] : sections) {
    tops.insert(top);
    const toml::table* table = subtable(root, top, source);
    if (table == nullptr || read.count(top) != 0) continue;
    SectionReader(*table, top, source).refuse_unknown(children);
  }
  SectionReader(root, "", source).refuse_unknown(tops);
  return config;
}

void apply_calibration(Config& config, std::string_view text, const std::string& source) {
  const toml::table root = parse_toml(text, source);
  SectionReader(root, "", source).refuse_unknown({"smdu_calibration"});
  const toml::table* table = subtable(root, "smdu_calibration", source);
  if (table == nullptr) throw ConfigError(source + ": has no section [smdu_calibration]");
  SectionReader reader(*table, "smdu_calibration", source);
  sahrs::FieldCalibration::describe(config.smdu_calibration, reader);
  reader.refuse_unknown();
}

void apply_calibration(Config& config, const sahrs::smdu::Record& record) {
  const sahrs::smdu::Calibration& stored = record.calibration;
  const sahrs::smdu::Spread spread = sahrs::smdu::spread(stored.P);
  const sahrs::smdu::FilterParameters& change = config.smdu_calibration_filter;
  config.smdu_calibration = {stored.matrix(), stored.bias(),
                             std::hypot(spread.bias, change.change_bias_sigma),
                             std::hypot(spread.matrix, change.change_matrix_sigma)};
}

std::string parameter_table() {
  std::ostringstream out;
  out << "| section | key | default | unit | allowed | meaning |\n|---|---|---|---|---|---|\n";
  const Config defaults;
  Config::describe(defaults, [&out](const std::string& name, const auto& parameters) {
    using Parameters = std::decay_t<decltype(parameters)>;
    Parameters::describe(parameters, TableWriter{out, name});
  });
  return out.str();
}

std::uint32_t calibration_id(const sahrs::FieldCalibration& calibration) {
  if (calibration.bias.isZero(0.0) && calibration.matrix.isIdentity(0.0)) return 0;
  std::array<char, 12 * sizeof(double)> bytes{};
  std::memcpy(bytes.data(), calibration.bias.data(), 3 * sizeof(double));
  std::memcpy(bytes.data() + 3 * sizeof(double), calibration.matrix.data(), 9 * sizeof(double));
  return math::crc32({bytes.data(), bytes.size()});
}

}  // namespace lodestar::navigator
