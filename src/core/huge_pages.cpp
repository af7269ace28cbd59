// Large arrays in huge pages, where the system gives them to those who ask (transparent_hugepage: madvise): a step goes
// over all of them, and 4 kB pages leave the processor's table of pages from about 10,000 grains on.

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

// Sanitizers have their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) // gcc
#define NAPPE_SANITIZED 1
#elif defined(__clang__)
#define NAPPE_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define NAPPE_SANITIZED 0
#endif
#if defined(__linux__) && !NAPPE_SANITIZED

namespace {

constexpr std::size_t huge = std::size_t{1} << 21;
constexpr std::size_t least = std::size_t{1} << 19; // smaller ones would leave most of their page empty

/// @param align a power of 2, at least what malloc gives
void* allocate(std::size_t size, std::size_t align) {
    const bool large = size >= least;
    const std::size_t unit = large && align < huge ? huge : align;
    const std::size_t whole = (size + unit - 1) / unit * unit;
    void* const p = whole < size ? nullptr : std::aligned_alloc(unit, whole > 0 ? whole : unit);
    if (p == nullptr) {
        throw std::bad_alloc();
    }
    if (large) {
        madvise(p, whole, MADV_HUGEPAGE); // a wish: pages are small where it is not granted
    }
    return p;
}

} // namespace

void* operator new(std::size_t size) {
    return allocate(size, alignof(std::max_align_t));
}

void* operator new(std::size_t size, std::align_val_t align) {
    return allocate(size, static_cast<std::size_t>(align));
}

void operator delete(void* p) noexcept {
    std::free(p);
}

void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}

void operator delete(void* p, std::align_val_t) noexcept {
    std::free(p);
}

void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}

#endif
