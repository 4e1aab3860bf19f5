# Writes OUTPUT, a header that defines RAYLEX_REVISION: the commit of SOURCE, followed by "+changes" if files differ from
# this commit, or "unknown" if SOURCE is not the top of a git working tree. Does not rewrite an unchanged header.
set(revision "unknown")
find_program(GIT_PROGRAM git)
if(GIT_PROGRAM AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND ${GIT_PROGRAM} -C ${SOURCE} rev-parse HEAD
                  OUTPUT_VARIABLE commit ERROR_QUIET RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed)
    set(revision "${commit}")
    execute_process(COMMAND ${GIT_PROGRAM} -C ${SOURCE} diff-index --quiet HEAD --
                    OUTPUT_QUIET ERROR_QUIET RESULT_VARIABLE changed)
    if(changed)
      string(APPEND revision "+changes")
    endif()
  endif()
endif()
set(text "// Written by experiments/cmake/revision.cmake at build time.\n#pragma once\n#define RAYLEX_REVISION \"${revision}\"\n")
set(before "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" before)
endif()
if(NOT before STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
