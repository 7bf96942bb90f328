# Everything Raysweep stands on, as Debian 12 ships it.
list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB")
find_package(TBB REQUIRED)
find_package(Imath REQUIRED)
find_package(OpenVDB REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(OpenImageIO REQUIRED)
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

# ITK reads medical and scientific volumes; DCMTK checks DICOM before it does. ITK's configuration needs C, and lists the
# tools of GDCM that Debian packages apart: harmless, but many lines.
enable_language(C)
find_package(HDF5 REQUIRED COMPONENTS C)
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(ITK QUIET COMPONENTS ITKIONRRD ITKIOMeta ITKIONIFTI ITKIOGDCM ITKNIFTI)
find_package(DCMTK QUIET)
find_package(ZLIB QUIET)
unset(CMAKE_MESSAGE_LOG_LEVEL)
set(itk_complete OFF)
if(ITK_FOUND AND DCMTK_FOUND AND ZLIB_FOUND)
    set(itk_complete ON)
endif()
option(RAYSWEEP_WITH_ITK "Import NRRD, MetaImage, NIfTI and DICOM (needs ITK, DCMTK and zlib)" ${itk_complete})
if(RAYSWEEP_WITH_ITK AND NOT itk_complete)
    message(FATAL_ERROR "RAYSWEEP_WITH_ITK is ON, but ITK, DCMTK or zlib was not found: install libinsighttoolkit5-dev, "
        "libdcmtk-dev and zlib1g-dev, or turn it OFF")
endif()
if(NOT RAYSWEEP_WITH_ITK)
    message(WARNING "Without ITK 'raysweep import' reads pictures and raw samples only")
endif()
