#include "raysweep/formats/declared_samples.h"

#include "raysweep/core/memory.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace raysweep {
namespace {

/// Walks through the file once, from its begin to its end, and keeps what was chosen. Spatial axes stand in the file in
/// the order that they have in memory, so what is kept is in order.
class Walk {
  public:
    Walk(const DeclaredSamples& samples, const ProgressCallback& progress, StoredVolume& volume)
        : samples_(samples),
          progress_(progress),
          volume_(volume),
          size_(sizeOf(samples.type)),
          to_(volume.samples.get()),
          bytes_(volume.count() * size_) {
        std::uint64_t span = size_;
        bool whole = true;
        for (const DeclaredAxis& axis : samples.axes) {
            spans_.push_back(span);
            whole_.push_back(whole);
            span *= std::uint64_t(axis.size);
            whole = whole && (axis.spatial || axis.size == 1);
        }
        spans_.push_back(span);
        whole_.push_back(whole);
    }

    void go() { take(samples_.axes.size()); }

    /// Bytes that were left behind the samples of all pieces.
    std::uint64_t rest() const { return rest_; }

  private:
    /// All that is chosen along the first `axes` axes.
    void take(std::size_t axes) {
        if (!volume_.complete) return;
        if (whole_[axes]) return keep(spans_[axes]);
        const DeclaredAxis& axis = samples_.axes[axes - 1];
        if (axes == 2 && !samples_.axes[0].spatial && axis.spatial) return pick(samples_.axes[0], axis.size);
        for (std::int64_t n = 0; n < axis.size; ++n) {
            if (axis.spatial || n == axis.chosen)
                take(axes - 1);
            else
                pass(spans_[axes - 1]);
        }
    }

    /// One of the samples that each pixel of a row has side by side.
    void pick(const DeclaredAxis& components, std::int64_t pixels) {
        constexpr std::int64_t kSome = 1 << 14;
        const std::uint64_t stride = size_ * std::uint64_t(components.size);
        const std::uint64_t first = size_ * std::uint64_t(components.chosen);
        const auto some = std::max<std::int64_t>(1, std::min(pixels, kSome / components.size));
        row_.resize(std::size_t(some) * stride);
        for (std::int64_t done = 0; done < pixels && volume_.complete; done += some) {
            const std::int64_t now = std::min(some, pixels - done);
            transfer(std::uint64_t(now) * stride, row_.data());
            for (std::int64_t n = 0; n < now; ++n, to_ += size_)
                std::memcpy(to_, row_.data() + std::uint64_t(n) * stride + first, size_);
        }
        tell();
    }

    void keep(std::uint64_t bytes) {
        constexpr std::uint64_t kSome = 1 << 24;
        for (std::uint64_t done = 0; done < bytes && volume_.complete; done += kSome) {
            const std::uint64_t now = std::min(kSome, bytes - done);
            transfer(now, to_);
            to_ += now;
            tell();
        }
    }

    void pass(std::uint64_t bytes) {
        constexpr std::uint64_t kSome = 1 << 26;  // so that unpacking what is passed over can be stopped, too
        for (std::uint64_t done = 0; done < bytes && volume_.complete; done += kSome) {
            transfer(std::min(kSome, bytes - done), nullptr);
            tell();
        }
    }

    /// Bytes of one piece or several; to nowhere: passed over.
    void transfer(std::uint64_t bytes, std::byte* to) {
        while (bytes > 0) {
            if (!source_) {
                const DataPiece& piece = samples_.pieces[piece_++];
                source_ = openPiece(piece, samples_.coding, samples_.type);
                left_ = piece.bytes;
            }
            const std::uint64_t now = std::min(bytes, left_);
            if (to)
                source_->read(to, now), to += now;
            else
                source_->skip(now);
            bytes -= now;
            left_ -= now;
            if (left_ > 0) continue;
            rest_ += source_->rest();
            source_.reset();
        }
    }

    void tell() {
        const auto done = double(to_ - volume_.samples.get());
        volume_.complete = report(progress_, "reading", std::min(1.0, done / double(bytes_)));
    }

    const DeclaredSamples& samples_;
    const ProgressCallback& progress_;
    StoredVolume& volume_;
    std::uint64_t size_;
    std::byte* to_;
    std::uint64_t bytes_;
    std::vector<std::uint64_t> spans_;  ///< bytes of the first n axes together
    std::vector<bool> whole_;           ///< all samples of the first n axes are kept
    std::vector<std::byte> row_;
    std::unique_ptr<SampleSource> source_;
    std::size_t piece_ = 0;
    std::uint64_t left_ = 0, rest_ = 0;
};

void swapBytes(StoredVolume& volume) {
    const std::size_t size = sizeOf(volume.type);
    std::byte* sample = volume.samples.get();
    for (std::uint64_t n = 0; n < volume.count(); ++n, sample += size) std::reverse(sample, sample + size);
}

}  // namespace

std::uint64_t bytesOf(const DeclaredSamples& samples, const std::string& path) {
    constexpr double kMost = 1e15;
    double bytes = double(sizeOf(samples.type));
    for (const DeclaredAxis& axis : samples.axes) {
        if (axis.size < 1)
            failRead(path, "its header promises " + std::to_string(axis.size) + " samples along an axis");
        bytes *= double(axis.size);
        if (!(bytes < kMost) || axis.size > std::numeric_limits<std::int32_t>::max())
            failRead(path, "its header promises more samples than any file holds");
    }
    return std::uint64_t(bytes);
}

void splitEvenly(DeclaredSamples& samples, const std::string& path) {
    const std::uint64_t bytes = bytesOf(samples, path), count = samples.pieces.size();
    if (count == 0 || bytes % (count * sizeOf(samples.type)) != 0)
        failRead(path, std::to_string(count) + " files cannot hold the " +
                           std::to_string(bytes / sizeOf(samples.type)) + " samples that its header promises");
    for (DataPiece& piece : samples.pieces) piece.bytes = bytes / count;
}

StoredVolume readDeclared(const std::string& path, const DeclaredSamples& samples, const ProgressCallback& progress) {
    requirePieces(samples.pieces, samples.coding, samples.type);
    StoredVolume volume;
    volume.dims = Index3(1);
    volume.type = samples.type;
    int spatial = 0;
    for (const DeclaredAxis& axis : samples.axes)
        if (axis.spatial) volume.dims[spatial++] = int(axis.size);
    const std::uint64_t bytes = volume.count() * sizeOf(volume.type);
    requireBytes(double(bytes), "'" + path + "': its samples alone need", "crop or resample it elsewhere first");
    volume.complete = report(progress, "reading", 0);
    if (!volume.complete) return volume;
    volume.samples.reset(new std::byte[bytes]);
    Walk walk(samples, progress, volume);
    walk.go();
    if (!volume.complete) return volume;
    if (walk.rest() > 0) {
        const std::string more = "its data go on behind the samples that its header promises";
        if (samples.exact) failRead(path, more + ": the header is wrong, or there is something before the samples");
        volume.notes.push_back(more + "; the rest was not read");
    }
    if (samples.bigEndian) swapBytes(volume);
    return volume;
}

}  // namespace raysweep
