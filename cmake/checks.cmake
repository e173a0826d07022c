# Every check that is no case of GoogleTest, as a test of CTest.
function(check name)
    add_test(NAME ${name} COMMAND ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 600)
endfunction()

check(shape tests/shape_test.sh)
check(includes tests/includes_test.sh)
check(docs tests/docs_test.sh)
check(headers_alone tests/headers_alone.sh)
check(program tests/cli/program_test.sh $<TARGET_FILE:knead>)
check(verbs tests/cli/verbs_test.sh $<TARGET_FILE:knead>)
if(KNEAD_INSTALL AND NOT (KNEAD_SANITIZE OR KNEAD_COVERAGE))
    check(install tests/install_test.sh ${CMAKE_BINARY_DIR})
    check(embed tests/embed_test.sh ${CMAKE_BINARY_DIR})
endif()
if(KNEAD_CUDA)
    check(kernels tests/kernels_test.sh ${CMAKE_BINARY_DIR})
endif()

# The reference of the installed headers, in reference/ of the build folder: by the target docs for
# people, as a check that there is no warning.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
    file(GLOB REFERENCE_INPUT RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS cuda/*/*.h
        host/*/*.h render/painter.h)
    list(FILTER REFERENCE_INPUT EXCLUDE REGEX "^host/(cli/|solver/pieces.h)")
    list(JOIN REFERENCE_INPUT " " REFERENCE_INPUT)
    set(REFERENCE_FOLDER ${CMAKE_BINARY_DIR}/reference)
    file(MAKE_DIRECTORY ${REFERENCE_FOLDER})
    configure_file(docs/Doxyfile.in ${CMAKE_BINARY_DIR}/Doxyfile @ONLY)
    add_custom_target(docs ${DOXYGEN_EXECUTABLE} ${CMAKE_BINARY_DIR}/Doxyfile
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} VERBATIM)
    check(reference ${DOXYGEN_EXECUTABLE} ${CMAKE_BINARY_DIR}/Doxyfile)
    set(knead_docs "reference by Doxygen")
else()
    set(knead_docs "no reference (Doxygen not found)")
endif()
