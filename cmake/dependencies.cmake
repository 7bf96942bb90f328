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

# Debian's OpenImageIO names an include folder that does not exist (/usr/include/opencv4): CMake refuses it.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER oiio_includes EXCLUDE REGEX "opencv4")
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}")
