#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace raysweep {

/// An array of zeros of which only what is written takes memory (in pages of the system): for tables over a range of
/// which few places are used. `Value` is one whose bits may all be 0.
template <class Value>
class ZeroedArray {
    static_assert(std::is_trivially_copyable<Value>::value, "its bits are set to 0");

  public:
    ZeroedArray() = default;
    /// @throw std::bad_alloc
    explicit ZeroedArray(std::size_t size)
        : data_(static_cast<Value*>(std::calloc(size > 0 ? size : 1, sizeof(Value)))) {
        if (!data_) throw std::bad_alloc();
    }

    Value* data() { return data_.get(); }
    const Value* data() const { return data_.get(); }
    Value& operator[](std::size_t i) { return data_.get()[i]; }
    const Value& operator[](std::size_t i) const { return data_.get()[i]; }

  private:
    struct Free {
        void operator()(Value* p) const { std::free(p); }
    };
    std::unique_ptr<Value[], Free> data_;
};

}  // namespace raysweep
