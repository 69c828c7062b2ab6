#include "micro/scene/pattern.h"

#include <cassert>
#include <numeric>

namespace trame::micro {

WeavePattern twill_pattern(const std::vector<Index>& floats) {
  std::vector<bool> above;  // along one warp yarn
  for (std::size_t k = 0; k < floats.size(); ++k) above.insert(above.end(), floats[k], k % 2 == 0);
  const std::size_t n = above.size();
  WeavePattern pattern(n, std::vector<bool>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) pattern[i][j] = above[(i + n - j) % n];
  return pattern;
}

WeavePattern layered_pattern(const WarpLevels& levels, Index n_layers) {
  const std::size_t n_columns = levels.front().size();
  WeavePattern pattern;
  for (std::size_t column = 0; column < n_columns; ++column)
    for (Index layer = 0; layer < n_layers; ++layer) {
      std::vector<bool>& row = pattern.emplace_back();
      for (const std::vector<Index>& warp : levels) row.push_back(warp[column] > layer);
    }
  return pattern;
}

bool is_satin(Index harnesses, Index step) {
  return step > 1 && step < harnesses - 1 && std::gcd(harnesses, step) == 1;
}

WeavePattern satin_pattern(Index harnesses, Index step) {
  assert(std::gcd(harnesses, step) == 1);
  WeavePattern pattern(harnesses, std::vector<bool>(harnesses, true));
  for (Index i = 0, below = 0; i < harnesses; ++i, below = (below + step) % harnesses) pattern[i][below] = false;
  return pattern;
}

WeavePattern continued(const WeavePattern& repeat, Index n_weft, Index n_warp, Index first_weft, Index first_warp) {
  WeavePattern pattern(n_weft, std::vector<bool>(n_warp));
  for (Index i = 0; i < n_weft; ++i) {
    const std::vector<bool>& row = repeat[(first_weft + i) % repeat.size()];
    for (Index j = 0; j < n_warp; ++j) pattern[i][j] = row[(first_warp + j) % row.size()];
  }
  return pattern;
}

}  // namespace trame::micro
