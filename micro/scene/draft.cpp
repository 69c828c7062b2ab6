#include "micro/scene/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>

#include "micro/core/error.h"
#include "micro/core/text.h"

namespace trame::micro {

namespace {

/// Jacquard looms have some ten thousand hooks; more is no draft.
constexpr Index most_yarns = 100'000, most_shafts = 100'000;
/// A warp yarn is on a shaft or two; a thousand picks of a Jacquard loom with all its hooks are some 10 million lifts.
constexpr std::size_t most_shafts_of_a_yarn = 16, most_lifts = 20'000'000;
constexpr std::size_t most_bytes = 16'000'000;

std::string lower(std::string_view text) {
  std::string copy(text);
  for (char& c : copy) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return copy;
}

std::string short_printable(std::string_view text) { return shortened(printable(text.substr(0, 400))); }
std::string listed(const std::vector<Index>& shafts) { return shortened(fmt::format("{}", fmt::join(shafts, ","))); }

std::optional<Index> number(std::string_view text) {
  Index n = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (status != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return n;
}

struct Entry {
  std::string key;  ///< in small letters
  std::string value;
  std::size_t line = 0;
};

/// The numbers of a line such as 3 = 1,4: shafts or treadles of a yarn, shafts of a treadle.
struct Members {
  std::vector<Index> members;  ///< ascending, without 0, which stands for none
  std::size_t line = 0;
};

class Wif {
 public:
  Wif(std::string_view text, std::string origin) : origin_(std::move(origin)) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    std::vector<Entry>* section = nullptr;
    for (std::size_t line = 1; !text.empty(); ++line) {
      const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
      const std::string_view whole = text.substr(0, end);
      const bool is_pair = end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n';
      text.remove_prefix(std::min(text.size(), end + (is_pair ? 2 : 1)));
      const std::string_view content = trimmed(whole.substr(0, whole.find(';')));
      if (content.empty()) continue;
      if (content.front() == '[') {
        section = &sections_[lower(trimmed(content.substr(1, content.find(']') - 1)))];
        continue;
      }
      const std::size_t equals = content.find('=');
      if (section && equals != content.npos)
        section->push_back(
            {lower(trimmed(content.substr(0, equals))), std::string(trimmed(content.substr(equals + 1))), line});
    }
  }

  [[nodiscard]] const std::vector<Entry>* find(const char* section) const {
    const auto found = sections_.find(lower(section));
    return found == sections_.end() ? nullptr : &found->second;
  }
  [[noreturn]] void fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}: {}", origin_, complaint));
  }
  [[noreturn]] void fail(const char* section, std::size_t line, const std::string& complaint) const {
    fail(fmt::format("[{}]: {} (line {})", section, complaint, line));
  }
  [[noreturn]] void fail(const char* section, const Entry& entry, const std::string& complaint) const {
    fail(section, entry.line,
         fmt::format("{} = {}: {}", short_printable(entry.key), short_printable(entry.value), complaint));
  }

  [[nodiscard]] const Entry* find(const char* section, const char* key) const {
    const std::vector<Entry>* entries = find(section);
    if (!entries) return nullptr;
    const auto found = std::find_if(entries->begin(), entries->end(), [&](const Entry& e) { return e.key == key; });
    return found == entries->end() ? nullptr : &*found;
  }
  [[nodiscard]] std::optional<Index> count(const char* section, const char* key) const {
    const Entry* entry = find(section, key);
    if (!entry) return std::nullopt;
    const std::optional<Index> n = number(entry->value);
    if (!n || *n < 0) fail(section, *entry, "must be a number of at least 0");
    return n;
  }
  [[nodiscard]] bool flag(const char* section, const char* key, bool fallback) const {
    const Entry* entry = find(section, key);
    if (!entry) return fallback;
    const std::string value = lower(entry->value);
    for (const char* yes : {"true", "on", "yes", "1"})
      if (value == yes) return true;
    for (const char* no : {"false", "off", "no", "0"})
      if (value == no) return false;
    fail(section, *entry, "must be true or false");
  }
  /// The lines of a section by their number.
  [[nodiscard]] std::map<Index, Members> members(const char* section) const {
    std::map<Index, Members> all;
    const std::vector<Entry>* entries = find(section);
    if (!entries) return all;
    for (const Entry& entry : *entries) {
      const std::optional<Index> n = number(entry.key);
      if (!n || *n < 0 || *n > most_yarns)
        fail(section, entry, fmt::format("must begin with a number from 1 to {}", most_yarns));
      Members read{{}, entry.line};
      for (std::string_view rest = entry.value; !rest.empty();) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        const std::string_view item = trimmed(rest.substr(0, comma));
        rest.remove_prefix(std::min(rest.size(), comma + 1));
        const std::optional<Index> member = item.empty() ? 0 : number(item);
        if (!member || *member < 0 || *member > most_shafts)
          fail(section, entry, fmt::format("must be numbers from 1 to {} with commas between them", most_shafts));
        if (*member > 0) read.members.push_back(*member);
      }
      std::sort(read.members.begin(), read.members.end());
      read.members.erase(std::unique(read.members.begin(), read.members.end()), read.members.end());
      const auto [before, is_new] = all.emplace(*n, read);
      if (!is_new && before->second.members != read.members)
        fail(section, entry, fmt::format("line {} says otherwise", before->second.line));
    }
    return all;
  }

 private:
  std::string origin_;
  std::map<std::string, std::vector<Entry>> sections_;
};

/// Entries of the yarns from the first one to the last one that has any, counted from 0; those without are empty.
std::vector<Members> by_yarn(const std::map<Index, Members>& numbered) {
  std::vector<Members> yarns;
  if (numbered.empty()) return yarns;
  const Index first = numbered.begin()->first == 0 ? 0 : 1;
  for (const auto& [n, entry] : numbered) {
    if (entry.members.empty()) continue;
    yarns.resize(static_cast<std::size_t>(n - first) + 1);
    yarns.back() = entry;
  }
  return yarns;
}

void check_shafts(const Wif& wif, const char* section, const std::map<Index, Members>& lines) {
  const std::optional<Index> n_shafts = wif.count("WEAVING", "shafts");
  if (!n_shafts || *n_shafts == 0) return;
  for (const auto& [n, entry] : lines)
    if (!entry.members.empty() && entry.members.back() > *n_shafts)
      wif.fail(section, entry.line,
               fmt::format("shaft {}, but [WEAVING] has shafts = {}", entry.members.back(), *n_shafts));
}

std::vector<std::vector<Index>> read_threading(const Wif& wif) {
  constexpr const char* section = "THREADING";
  const auto lines = wif.members(section);
  check_shafts(wif, section, lines);
  const std::vector<Members> yarns = by_yarn(lines);
  if (yarns.empty())
    wif.fail("has no [THREADING] that tells the shafts of its warp yarns; must be a draft in WIF, version 1.1");
  std::vector<std::vector<Index>> threading;
  for (const Members& yarn : yarns) {
    if (yarn.members.empty()) {
      const std::size_t n = threading.size() + 1, before = n > 1 ? yarns[n - 2].line : yarns.back().line;
      wif.fail(section, yarn.line > 0 ? yarn.line : before,
               fmt::format("warp yarn {} is on no shaft, though later ones are", n));
    }
    if (yarn.members.size() > most_shafts_of_a_yarn)
      wif.fail(
          section, yarn.line,
          fmt::format("{} shafts of one warp yarn; must be at most {}", yarn.members.size(), most_shafts_of_a_yarn));
    threading.push_back(yarn.members);
  }
  return threading;
}

/// Shafts that each pick moves by its treadles; nothing where there is no treadling.
std::vector<Members> read_treadling(const Wif& wif) {
  const auto tie_up = wif.members("TIEUP");
  const bool is_direct =
      std::all_of(tie_up.begin(), tie_up.end(), [](const auto& treadle) { return treadle.second.members.empty(); });
  check_shafts(wif, "TIEUP", tie_up);
  std::vector<Members> picks = by_yarn(wif.members("TREADLING"));
  if (is_direct) return picks;
  std::size_t n_lifts = 0;
  for (Members& pick : picks) {
    std::vector<Index> shafts;
    for (const Index treadle : pick.members) {
      const auto tied = tie_up.find(treadle);
      if (tied == tie_up.end())
        wif.fail("TREADLING", pick.line, fmt::format("treadle {} has no line in [TIEUP]", treadle));
      n_lifts += tied->second.members.size();
      if (n_lifts > most_lifts)
        wif.fail("TREADLING", pick.line, fmt::format("more than {} lifts of shafts up to this line", most_lifts));
      shafts.insert(shafts.end(), tied->second.members.begin(), tied->second.members.end());
    }
    std::sort(shafts.begin(), shafts.end());
    shafts.erase(std::unique(shafts.begin(), shafts.end()), shafts.end());
    pick.members = shafts;
  }
  return picks;
}

std::vector<std::vector<Index>> read_lifts(const Wif& wif) {
  const auto liftplan_lines = wif.members("LIFTPLAN");
  std::vector<Members> picks = by_yarn(liftplan_lines);
  if (picks.empty()) {
    picks = read_treadling(wif);
  } else if (wif.find("TIEUP")) {
    // Programs that write both mean the same by them.
    const std::vector<Members> treadled = read_treadling(wif);
    for (std::size_t i = 0; i < std::min(picks.size(), treadled.size()); ++i)
      if (picks[i].members != treadled[i].members)
        wif.fail("LIFTPLAN", std::max(picks[i].line, std::size_t{1}),
                 fmt::format("weft yarn {} has shafts {}, but by [TREADLING] and [TIEUP] {} (line {})", i + 1,
                             listed(picks[i].members), listed(treadled[i].members), treadled[i].line));
  }
  if (picks.empty())
    wif.fail(
        "has neither [LIFTPLAN] nor [TREADLING] that tells the shafts of its weft yarns; must be a draft in WIF, "
        "version 1.1");
  std::vector<std::vector<Index>> lifts;
  lifts.reserve(picks.size());
  for (const Members& pick : picks) lifts.push_back(pick.members);
  return lifts;
}

}  // namespace

bool Draft::warp_above(Index weft, Index warp) const {
  const std::vector<Index>&moved = lifts[weft], &on = threading[warp];
  const bool moves = std::any_of(on.begin(), on.end(),
                                 [&](Index shaft) { return std::binary_search(moved.begin(), moved.end(), shaft); });
  return moves == rising_shed;
}

Draft parse_draft(std::string_view text, const std::string& origin) {
  const Wif wif(text, origin);
  Draft draft;
  draft.threading = read_threading(wif);
  draft.lifts = read_lifts(wif);
  draft.rising_shed = wif.flag("WEAVING", "rising shed", true);
  return draft;
}

Draft read_draft(const std::filesystem::path& file) {
  const std::string name = made_plain(file.string());
  std::error_code none;
  const auto kind = std::filesystem::status(file, none).type();
  if (kind == std::filesystem::file_type::directory)
    throw InputError(fmt::format("{}: is a folder; must be a draft in WIF", name));
  // Reading a pipe would wait for whoever writes into it.
  if (std::filesystem::exists(std::filesystem::file_status(kind)) && kind != std::filesystem::file_type::regular)
    throw InputError(fmt::format("{}: is no file; must be a draft in WIF", name));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: cannot be read; must be a draft in WIF", name));
  std::string text(most_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > most_bytes) throw InputError(fmt::format("{}: a draft has at most {} bytes", name, most_bytes));
  return parse_draft(text, name);
}

WeavePattern pattern_of(const Draft& draft, Index first_weft, Index first_warp, Index n_weft, Index n_warp) {
  WeavePattern pattern(n_weft, std::vector<bool>(n_warp));
  for (Index i = 0; i < n_weft; ++i)
    for (Index j = 0; j < n_warp; ++j)
      pattern[i][j] = draft.warp_above((first_weft + i) % draft.n_weft(), (first_warp + j) % draft.n_warp());
  return pattern;
}

}  // namespace trame::micro
