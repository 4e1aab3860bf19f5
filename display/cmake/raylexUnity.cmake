# raylex_unity(<out> <source>...): the sources to compile in place of these. Those of one folder are compiled
# together, at most RAYLEX_UNITY_BATCH in one go, which takes about half the time: headers are parsed, and templates that
# several sources use are compiled, once. CMake's own UNITY_BUILD writes absolute paths: no two clones would share a
# compiler cache.
#
# Sources that are compiled together see each other's anonymous namespaces: equal names there are an error of the
# compiler. raylex_compile_alone() keeps a source by itself: one that holds the code of a library, say. Generated ones
# stay so, too.
function(raylex_unity out)
  set(result "")
  set(folders "")
  foreach(source ${ARGN})
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    cmake_path(IS_PREFIX CMAKE_CURRENT_SOURCE_DIR ${source} inside)
    get_source_file_property(alone ${source} RAYLEX_COMPILE_ALONE)
    if(RAYLEX_UNITY_BATCH LESS_EQUAL 1 OR alone STREQUAL "TRUE" OR NOT inside)
      list(APPEND result ${source})
      continue()
    endif()
    cmake_path(GET source PARENT_PATH folder)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER ${folder} key)
    list(APPEND folders ${key})
    list(APPEND sources_${key} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(key ${folders})
    # As many batches as it takes, of nearly equal length.
    list(LENGTH sources_${key} count)
    math(EXPR batches "(${count} + ${RAYLEX_UNITY_BATCH} - 1) / ${RAYLEX_UNITY_BATCH}")
    math(EXPR length "(${count} + ${batches} - 1) / ${batches}")
    foreach(batch RANGE 1 ${batches})
      math(EXPR first "(${batch} - 1) * ${length}")
      list(SUBLIST sources_${key} ${first} ${length} members)
      set(text "// Written by display/cmake/raylexUnity.cmake.\n")
      foreach(member ${members})
        file(RELATIVE_PATH member ${PROJECT_SOURCE_DIR} ${member})
        string(APPEND text "#include \"${member}\"\n")
      endforeach()
      set(unity ${CMAKE_CURRENT_BINARY_DIR}/unity/${key}_${batch}.cpp)
      file(CONFIGURE OUTPUT ${unity} CONTENT "${text}" @ONLY)
      set(options ${RAYLEX_UNITY_OPTIONS})
      if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        # g++ takes all files but the one on its command line for headers, where anonymous types in classes are a slip.
        list(APPEND options -Wno-subobject-linkage)
      endif()
      set_source_files_properties(${unity} PROPERTIES COMPILE_OPTIONS "${options}")
      list(APPEND result ${unity})
    endforeach()
  endforeach()
  set(${out} ${result} PARENT_SCOPE)
endfunction()

# raylex_compile_alone(<source>...)
function(raylex_compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES RAYLEX_COMPILE_ALONE TRUE)
endfunction()
