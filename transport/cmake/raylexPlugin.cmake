# Functions that build plugins, and programs that load them, in the source tree and after find_package(raylex).

# raylex_add_plugin(<name> <sources>...): a shared library lib<name>.so for `raylex render --plugin`. It contains no copy of raylex:
# every symbol comes from the program that loads it, so that each registry exists once.
function(raylex_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  target_link_libraries(${name} PRIVATE raylex::plugin)
endfunction()

# raylex_plugin_host(<program> raylex::<component>...): a program that can load plugins. All of each component is linked, whether the
# program uses it or not, and exported to the plugins.
function(raylex_plugin_host program)
  set(archives "")
  foreach(component ${ARGN})
    list(APPEND archives "$<TARGET_FILE:${component}>")
  endforeach()
  set_target_properties(${program} PROPERTIES ENABLE_EXPORTS ON)
  # CMake lists the libraries again, for their order and dependencies; no symbol is missing by then.
  target_link_options(${program} PRIVATE "LINKER:--whole-archive" ${archives} "LINKER:--no-whole-archive")
  target_link_libraries(${program} PRIVATE ${ARGN})
endfunction()
