# Writes a header with the commit of the source tree, and "-dirty" where the tree was changed.
# usage: cmake -DSOURCE=folder -DTO=header -P commit.cmake
set(commit unknown)
find_program(git git)
if(git)
    execute_process(COMMAND ${git} describe --always --dirty --abbrev=40 --exclude=*
        WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE said OUTPUT_STRIP_TRAILING_WHITESPACE
        RESULT_VARIABLE failed ERROR_QUIET)
    if(NOT failed)
        set(commit "${said}")
    endif()
endif()
file(CONFIGURE OUTPUT ${TO} CONTENT "#pragma once\n#define KNEAD_COMMIT \"${commit}\"\n")
