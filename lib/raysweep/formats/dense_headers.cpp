#include "raysweep/formats/dense_headers.h"

#include "raysweep/core/exact.h"

namespace raysweep {
namespace {

std::string listOf(const Vec3& v, const char* separator) {
    return exact(v.x) + separator + exact(v.y) + separator + exact(v.z);
}

std::string listOf(const Index3& v) {
    return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
}

}  // namespace

std::string metaImageHeader(const DenseLayout& layout) {
    if (!hasRightAngles(layout))
        throw InvalidArgument("the volume's axes are sheared, which MetaImage cannot say; write NRRD or NIfTI");
    const Vec3 spacing = layout.spacing();
    std::string directions;
    for (int axis = 0; axis < 3; ++axis)
        directions += " " + listOf(layout.steps[std::size_t(axis)] / spacing[axis], " ");
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
           "TransformMatrix =" +
           directions + "\nOffset = " + listOf(layout.origin, " ") +
           "\nCenterOfRotation = 0 0 0\nElementSpacing = " + listOf(spacing, " ") +
           "\nDimSize = " + listOf(layout.dims) + "\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n";
}

std::string nrrdHeader(const DenseLayout& layout) {
    std::string directions;
    for (const Vec3& step : layout.steps) directions += " (" + listOf(step, ",") + ")";
    return "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: " + listOf(layout.dims) +
           "\nspace directions:" + directions + "\nkinds: domain domain domain\nendian: little\nencoding: raw\n" +
           "space origin: (" + listOf(layout.origin, ",") + ")\n\n";
}

}  // namespace raysweep
