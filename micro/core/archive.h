#pragma once
/// \file
/// Values as bytes and back, to the bit. What is kept of a type stands in one function, which serves both ways, so that
/// they cannot disagree: a member `void keep(Archive& archive) { archive(first, second); }`. The bytes are for the same
/// program on the same machine: neither their order nor their widths are converted.

#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "micro/core/types.h"

namespace trame {

/// Bytes that are not what is read: cut short, or of something else.
class ArchiveError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Archive {
 public:
  /// To write to.
  Archive() = default;
  /// To read from.
  explicit Archive(std::string bytes) : bytes_(std::move(bytes)), reads_(true) {}

  [[nodiscard]] bool reads() const { return reads_; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  /// Whether all has been read.
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

  /// Passes values through: reads them, or writes them.
  template <class... T>
  void operator()(T&... values) {
    (pass(values), ...);
  }
  /// Fails on reading what cannot be.
  void require(bool plausible, const char* what) const {
    if (reads_ && !plausible) throw ArchiveError(what);
  }

 private:
  template <class T>
  static constexpr bool is_plain =
      std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, Vec3> || std::is_same_v<T, Mat3>;

  void pass_bytes(void* data, std::size_t n) {
    if (n == 0) return;
    if (!reads_) {
      bytes_.append(static_cast<const char*>(data), n);
      return;
    }
    require(n <= bytes_.size() - at_, "the bytes end early");
    std::memcpy(data, bytes_.data() + at_, n);
    at_ += n;
  }
  template <class T>
  void pass(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      auto byte = static_cast<std::uint8_t>(value);
      pass_bytes(&byte, 1);
      require(byte <= 1, "a truth value that is none");
      value = byte != 0;
    } else if constexpr (is_plain<T>) {
      pass_bytes(&value, sizeof value);
    } else {
      value.keep(*this);
    }
  }
  /// A length, of which each item takes at least `least_bytes`.
  [[nodiscard]] std::size_t pass_length(std::size_t length, std::size_t least_bytes) {
    auto n = static_cast<std::uint64_t>(length);
    pass_bytes(&n, sizeof n);
    require(n <= (bytes_.size() - at_) / least_bytes, "a list longer than its bytes");
    return n;
  }
  void pass(std::string& text) {
    text.resize(pass_length(text.size(), 1));
    pass_bytes(text.data(), text.size());
  }
  template <class T>
  void pass(std::vector<T>& values) {
    values.resize(pass_length(values.size(), is_plain<T> ? sizeof(T) : 1));
    if constexpr (is_plain<T> && !std::is_same_v<T, bool>)
      pass_bytes(values.data(), values.size() * sizeof(T));
    else
      for (T& value : values) pass(value);
  }
  template <class T>
  void pass(std::optional<T>& value) {
    bool has = value.has_value();
    pass(has);
    if (reads_) value = has ? std::optional<T>(T()) : std::nullopt;
    if (has) pass(*value);
  }

  std::string bytes_;
  std::size_t at_ = 0;
  bool reads_ = false;
};

}  // namespace trame
