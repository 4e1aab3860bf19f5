# What plugins, and programs that load them, are built with. In the source tree and after find_package(raylex) alike.

# raylex_add_plugin(<name> <sources>...): a shared library lib<name>.so for `raylex render --plugin`. It holds no copy of raylex:
# every symbol comes from the program that loads it, so that there is one of each registry.
function(raylex_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  target_link_libraries(${name} PRIVATE raylex::plugin)
endfunction()

# raylex_plugin_host(<program> raylex::<component>...): a program that can load plugins. All of each component is linked, used by the
# program or not, and exported to the plugins.
function(raylex_plugin_host program)
  set(archives "")
  foreach(component ${ARGN})
    list(APPEND archives "$<TARGET_FILE:${component}>")
  endforeach()
  set_target_properties(${program} PROPERTIES ENABLE_EXPORTS ON)
  # The libraries come once more where CMake puts them, for their order and dependencies; by then nothing is missing.
  target_link_options(${program} PRIVATE "LINKER:--whole-archive" ${archives} "LINKER:--no-whole-archive")
  target_link_libraries(${program} PRIVATE ${ARGN})
endfunction()
