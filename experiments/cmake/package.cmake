# Debian packages, one for each install component: cpack --config build/release/CPackConfig.cmake
set(RAYLEX_MAINTAINER "raylex maintainers <maintainers@example.org>" CACHE STRING "Name <mail>")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME raylex)
set(CPACK_PACKAGE_CONTACT ${RAYLEX_MAINTAINER})
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
# Copyright, changelog, compressed pages, and Python's folder as Debian has it.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/package_files.cmake)

# What the static libraries and their headers need is what the build needs.
file(STRINGS ${PROJECT_SOURCE_DIR}/experiments/packages.txt needs REGEX "^[^#]")
string(REGEX MATCHALL "[a-z0-9-]+-dev" needs "${needs}")
list(FILTER needs EXCLUDE REGEX "python|pybind")
list(JOIN needs ", " needs)
set(version "${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")

set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME raylex)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS libjs-d3)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "libraylex-dev, python3-raylex, graphviz")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "raylex renders pbrt-v4 scenes, splits their light by light path
expressions, proves that the splits add up, and runs studies of
accuracy against time.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libraylex-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "raylex (= ${version}), ${needs}")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers, static libraries, and CMake and pkg-config files, for
programs and plugins that use raylex.")
if(TARGET raylex_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next "${RAYLEX_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-raylex)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "raylex (= ${version}), python3-numpy, \
python3 (>= 3.${RAYLEX_PYTHON_MINOR}), python3 (<< 3.${next})")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Renders and studies with NumPy arrays; integrators, textures and
sample filters as Python classes.")
endif()
include(CPack)
