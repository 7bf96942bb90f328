// Blocks of values, packed or not. OpenVDB 10 copies a block that is said not to be packed before it asks if it is as
// long as the memory that it goes to, and lets Blosc read past the end of one that says that it is longer. Functions of
// a program stand in for those of a shared library that have the same names, so these take the place of OpenVDB's;
// weak, so that they do not clash with those of a static one.
#include <openvdb/Exceptions.h>
#include <openvdb/Types.h>
#include <openvdb/io/Compression.h>

#include <blosc.h>
#include <zlib.h>

#include <istream>
#include <memory>
#include <string>

namespace {

[[noreturn]] void fail(std::size_t bytes) {
    throw openvdb::RuntimeError("a block of " + std::to_string(bytes) + " bytes of values is damaged");
}

/// @param to null: pass over it  @param most bytes of `bytes` when they are packed  @param unpack of (packed, length),
/// true if it got `bytes`
template <class Unpack>
void readBlock(std::istream& in, char* to, std::size_t bytes, std::size_t most, const Unpack& unpack) {
    openvdb::Int64 length = 0;  // negative: not packed
    in.read(reinterpret_cast<char*>(&length), sizeof length);
    if (length > 0) {
        if (std::size_t(length) > most) fail(bytes);
        if (!to) {
            in.seekg(length, std::ios::cur);
            return;
        }
        const std::unique_ptr<char[]> packed(new char[std::size_t(length)]);
        in.read(packed.get(), length);
        if (!unpack(packed.get(), std::size_t(length))) fail(bytes);
        return;
    }
    if (std::size_t(0) - std::size_t(length) != bytes) fail(bytes);
    if (to)
        in.read(to, -length);
    else
        in.seekg(-length, std::ios::cur);
}

}  // namespace

[[gnu::weak]] void openvdb::io::unzipFromStream(std::istream& in, char* data, size_t numBytes) {
    readBlock(in, data, numBytes, ::compressBound(numBytes), [&](const char* packed, std::size_t length) {
        uLongf got = numBytes;
        const int status =
            ::uncompress(reinterpret_cast<Bytef*>(data), &got, reinterpret_cast<const Bytef*>(packed), uLong(length));
        return status == Z_OK && got == numBytes;
    });
}

[[gnu::weak]] void openvdb::io::bloscFromStream(std::istream& in, char* data, size_t numBytes) {
    readBlock(in, data, numBytes, numBytes + BLOSC_MAX_OVERHEAD, [&](const char* packed, std::size_t length) {
        std::size_t promised = 0;
        return ::blosc_cbuffer_validate(packed, length, &promised) == 0 && promised == numBytes &&
               ::blosc_decompress_ctx(packed, data, numBytes, /*numinternalthreads=*/1) == int(numBytes);
    });
}
