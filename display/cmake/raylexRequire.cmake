# raylex_require(<Debian package> package|path|library <arguments of find_package, find_path or find_library>...): a
# missing library stops with the name of the package that has it in Debian and Ubuntu.
macro(raylex_require debian kind name)
  cmake_language(CALL find_${kind} ${name} ${ARGN})
  if(NOT ${name} AND NOT ${name}_FOUND)
    message(FATAL_ERROR "${name} was not found (${ARGN}). Debian and Ubuntu: apt-get install ${debian}; all that "
                        "raylex needs: bash experiments/install_packages.sh")
  endif()
endmacro()
