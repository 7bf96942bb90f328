/// The structure of DICOM files, which is walked before DCMTK and GDCM see them.
#include "raysweep/formats/dicom_walk.h"
#include "fuzzed_file.h"

using namespace raysweep;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::FuzzedFile file(data, size);
    return fuzz::accepts([&] { walkDicom(file.path()); });
}
