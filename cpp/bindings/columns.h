// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "fields.h"

namespace lodestar::bindings {

namespace py = pybind11;

// A member as a run of numbers: {pointer to the first, how many}.
template <class T>
std::pair<T*, std::size_t> numbers(T& scalar) {
  return {&scalar, 1};
}
template <int N>
std::pair<double*, std::size_t> numbers(Eigen::Matrix<double, N, 1>& vector) {
  return {vector.data(), N};
}
template <int N>
std::pair<const double*, std::size_t> numbers(const Eigen::Matrix<double, N, 1>& vector) {
  return {vector.data(), N};
}
template <class T, std::size_t N>
std::pair<const T*, std::size_t> numbers(const std::array<T, N>& array) {
  return {array.data(), N};
}

/// Samples out of the NumPy arrays of one channel, {field: (n, ...) array}.
template <class Sample>
class SampleRows {
 public:
  /// Throws std::invalid_argument for a missing field, a wrong type or a wrong shape.
  SampleRows(const std::string& channel, const py::dict& arrays) {
    Sample sample;
    fields(sample, [&](const char* name, auto& member) {
      const auto [data, count] = numbers(member);
      using T = std::remove_pointer_t<decltype(data)>;
      const std::string key = channel + "/" + name;
      if (!arrays.contains(name)) throw std::invalid_argument(key + ": missing");
      const auto array = py::array::ensure(arrays[name], py::array::c_style);
      if (!array || !array.dtype().equal(py::dtype::of<T>())) {
        throw std::invalid_argument(key + ": type must be " +
                                    std::string(py::str(py::dtype::of<T>())));
      }
      if (columns_.empty()) rows_ = array.shape(0);
      if (array.shape(0) != rows_ || array.size() != rows_ * static_cast<py::ssize_t>(count)) {
        throw std::invalid_argument(key + ": wrong shape");
      }
      columns_.push_back(array);
      bytes_.push_back(static_cast<const char*>(array.data()));
    });
  }

  py::ssize_t rows() const { return rows_; }

  Sample at(std::size_t row) const {
    Sample sample;
    std::size_t column = 0;
    fields(sample, [&](const char*, auto& member) {
      const auto [data, count] = numbers(member);
      const std::size_t size = count * sizeof(*data);
      std::memcpy(data, bytes_[column++] + row * size, size);
    });
    return sample;
  }

 private:
  std::vector<py::array> columns_;  // keeps the memory of bytes_ alive
  std::vector<const char*> bytes_;
  py::ssize_t rows_ = 0;
};

/// Outputs of one channel collected into NumPy arrays, {field: (n, ...) array}.
template <class Sample>
class SampleCollector {
 public:
  void add(const Sample& sample) {
    std::size_t column = 0;
    fields(sample, [&](const char*, const auto& member) {
      const auto [data, count] = numbers(member);
      if (column == bytes_.size()) bytes_.emplace_back();
      const char* first = reinterpret_cast<const char*>(data);
      bytes_[column].insert(bytes_[column].end(), first, first + count * sizeof(*data));
      ++column;
    });
    ++rows_;
  }

  py::dict arrays() const {
    py::dict result;
    std::size_t column = 0;
    const Sample shape{};
    fields(shape, [&](const char* name, const auto& member) {
      const auto [data, count] = numbers(member);
      using T = std::remove_const_t<std::remove_pointer_t<decltype(data)>>;
      std::vector<py::ssize_t> dimensions{rows_};
      if (std::string_view(name) == "rejected" && count > 1) {
        dimensions.insert(dimensions.end(), {samples::kChannels, samples::kReasons});
      } else if (count > 1) {
        dimensions.push_back(static_cast<py::ssize_t>(count));
      }
      py::array_t<T> array(dimensions);
      if (rows_ > 0)
        std::memcpy(array.mutable_data(), bytes_[column].data(), bytes_[column].size());
      result[name] = array;
      ++column;
    });
    return result;
  }

 private:
  std::vector<std::vector<char>> bytes_;
  py::ssize_t rows_ = 0;
};

}  // namespace lodestar::bindings
