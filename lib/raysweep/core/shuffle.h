/// Random order, the same everywhere: the standard library's shuffle differs from one to the next.
#pragma once

#include <cstddef>
#include <random>
#include <utility>
#include <vector>

namespace raysweep {

template <class Item>
void shuffle(std::vector<Item>& items, std::mt19937& random) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random() % i]);
}

}  // namespace raysweep
