# Everything Raysweep stands on, as Debian 12 ships it.
list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB")
find_package(TBB REQUIRED)
find_package(Imath REQUIRED)
find_package(OpenVDB REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(TIFF REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(HWY REQUIRED)
find_package(CLI11 REQUIRED)
# Only its header is used, whose transforms are templates.
find_path(KISSFFT_INCLUDE_DIR kissfft/kissfft.hh)
if(NOT KISSFFT_INCLUDE_DIR)
    message(FATAL_ERROR "kissfft/kissfft.hh was not found: install libkissfft-dev")
endif()
find_package(pugixml REQUIRED)

# Debian's OpenImageIO names an include folder that does not exist (/usr/include/opencv4): CMake refuses it.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER oiio_includes EXCLUDE REGEX "opencv4")
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}")

# zlib unpacks NRRD, MetaImage and NIfTI. ITK's GDCM reads DICOM; DCMTK checks it before. ITK's configuration needs C, and lists the
# tools of GDCM that Debian packages apart: harmless, but many lines.
enable_language(C)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(ZLIB REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(ITK QUIET COMPONENTS ITKIOMeta ITKIOGDCM)
find_package(DCMTK QUIET)
unset(CMAKE_MESSAGE_LOG_LEVEL)
set(itk_complete OFF)
if(ITK_FOUND AND DCMTK_FOUND)
    set(itk_complete ON)
endif()
option(RAYSWEEP_WITH_ITK "Import DICOM and write MetaImage (needs ITK and DCMTK)" ${itk_complete})
if(RAYSWEEP_WITH_ITK AND NOT itk_complete)
    message(FATAL_ERROR "RAYSWEEP_WITH_ITK is ON, but ITK or DCMTK was not found: install libinsighttoolkit5-dev and "
        "libdcmtk-dev, or turn it OFF")
endif()
if(NOT RAYSWEEP_WITH_ITK)
    message(WARNING "Without ITK 'raysweep import' reads no DICOM")
endif()
