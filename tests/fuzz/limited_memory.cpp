/// Memory as it ends: OpenVDB takes it for as many attributes of points as a file says. An exception says that there is
/// not so much, but sanitizers end the program. In a unit of its own, as GCC warns where it sees through `delete`.
#include <cstddef>
#include <cstdlib>
#include <new>

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    constexpr std::size_t kMost = std::size_t(1) << 30;
    return size <= kMost ? std::malloc(size > 0 ? size : 1) : nullptr;
}
void* operator new(std::size_t size) {
    if (void* const memory = operator new(size, std::nothrow)) return memory;
    throw std::bad_alloc();
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return operator new(size, std::nothrow);
}
void* operator new[](std::size_t size) {
    return operator new(size);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    std::free(memory);
}
