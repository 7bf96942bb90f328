#include "raysweep/core/natural_order.h"

#include <cstddef>

namespace raysweep {
namespace {

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

/// The number that starts at `at`, without leading zeros; `at` ends behind it.
std::string number(const std::string& text, std::size_t& at) {
    while (at < text.size() && text[at] == '0') ++at;
    const std::size_t begin = at;
    while (at < text.size() && isDigit(text[at])) ++at;
    return text.substr(begin, at - begin);
}

}  // namespace

bool naturallyBefore(const std::string& a, const std::string& b) {
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (isDigit(a[i]) && isDigit(b[j])) {
            const std::string m = number(a, i), n = number(b, j);
            if (m.size() != n.size()) return m.size() < n.size();
            if (m != n) return m < n;
        } else {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i, ++j;
        }
    }
    const std::size_t left = a.size() - i, right = b.size() - j;
    if (left != right) return left < right;
    return a < b;  // the same but for leading zeros
}

}  // namespace raysweep
