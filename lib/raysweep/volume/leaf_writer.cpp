#include "raysweep/volume/leaf_writer.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <ostream>
#include <streambuf>
#include <string>
#include <vector>

namespace raysweep {
namespace {

/// Bytes written to memory.
class Bytes : public std::streambuf {
  public:
    void reserve(std::size_t size) { bytes_.reserve(size); }
    const std::string& get() const { return bytes_; }

  protected:
    std::streamsize xsputn(const char* from, std::streamsize count) override {
        bytes_.append(from, std::size_t(count));
        return count;
    }
    int_type overflow(int_type c) override {
        bytes_.push_back(traits_type::to_char_type(c));
        return c;
    }

  private:
    std::string bytes_;
};

/// The buffers of a tree's leaves follow each other in the tree's order, and each depends on nothing but its leaf.
template <class GridType>
class ParallelGrid : public GridType {
  public:
    explicit ParallelGrid(const GridType& grid) : GridType(const_cast<GridType&>(grid), openvdb::ShallowCopy()) {}

    void writeBuffers(std::ostream& out) const override {
        std::vector<const Leaf*> leaves;
        leaves.reserve(this->tree().leafCount());
        this->tree().getNodes(leaves);
        constexpr std::size_t kPiece = 64, kPiecesAtOnce = 128;  // in memory at once: at most 16 MB per channel
        for (std::size_t first = 0; first < leaves.size(); first += kPiece * kPiecesAtOnce) {
            const std::size_t end = std::min(leaves.size(), first + kPiece * kPiecesAtOnce);
            std::vector<Bytes> pieces((end - first + kPiece - 1) / kPiece);
            parallelFor(pieces.size(), [&](std::size_t i) {
                const std::size_t begin = first + i * kPiece;
                writePiece(out, leaves.data() + begin, std::min(kPiece, end - begin), pieces[i]);
            });
            for (const Bytes& piece : pieces) out.write(piece.get().data(), std::streamsize(piece.get().size()));
        }
    }

  private:
    using Leaf = typename GridType::TreeType::LeafNodeType;

    void writePiece(std::ostream& file, const Leaf* const* leaves, std::size_t count, Bytes& bytes) const {
        bytes.reserve(count * Leaf::NUM_VOXELS * sizeof(typename GridType::ValueType));
        std::ostream out(&bytes);
        out.copyfmt(file);  // how to compress, and the background, hang on the stream
        for (std::size_t i = 0; i < count; ++i) leaves[i]->writeBuffers(out, this->saveFloatAsHalf());
    }
};

}  // namespace

openvdb::GridBase::Ptr writtenInParallel(const openvdb::GridBase::ConstPtr& grid) {
    if (const auto scalar = openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid))
        return std::make_shared<ParallelGrid<openvdb::FloatGrid>>(*scalar);
    if (const auto vector = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(grid))
        return std::make_shared<ParallelGrid<openvdb::Vec3SGrid>>(*vector);
    return openvdb::ConstPtrCast<openvdb::GridBase>(grid->copyGrid());
}

}  // namespace raysweep
