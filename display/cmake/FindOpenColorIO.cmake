# Finds OpenColorIO by its header and library. Debian 12's own CMake package is not in CMake's search path, and its
# prefix resolves to "/", so it cannot be used.
# Defines OpenColorIO_FOUND, OpenColorIO_VERSION and the target OpenColorIO::OpenColorIO.
find_path(OpenColorIO_INCLUDE_DIR OpenColorIO/OpenColorIO.h)
find_library(OpenColorIO_LIBRARY OpenColorIO)
if(OpenColorIO_INCLUDE_DIR AND EXISTS "${OpenColorIO_INCLUDE_DIR}/OpenColorIO/OpenColorABI.h")
  file(STRINGS "${OpenColorIO_INCLUDE_DIR}/OpenColorIO/OpenColorABI.h" _ocio_version REGEX "#define OCIO_VERSION[ \t]+\"")
  string(REGEX REPLACE ".*\"([0-9.]+)[^\"]*\".*" "\\1" OpenColorIO_VERSION "${_ocio_version}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenColorIO REQUIRED_VARS OpenColorIO_LIBRARY OpenColorIO_INCLUDE_DIR
                                  VERSION_VAR OpenColorIO_VERSION)
if(OpenColorIO_FOUND AND NOT TARGET OpenColorIO::OpenColorIO)
  add_library(OpenColorIO::OpenColorIO UNKNOWN IMPORTED)
  set_target_properties(OpenColorIO::OpenColorIO PROPERTIES IMPORTED_LOCATION "${OpenColorIO_LIBRARY}"
                        INTERFACE_INCLUDE_DIRECTORIES "${OpenColorIO_INCLUDE_DIR}")
endif()
mark_as_advanced(OpenColorIO_INCLUDE_DIR OpenColorIO_LIBRARY)
