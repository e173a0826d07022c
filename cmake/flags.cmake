# How our own files are compiled. Private: who links the libraries keeps his own flags.
add_library(knead_options INTERFACE)
# Never -ffast-math nor -ffinite-math-only: the guards must see what is not finite.
target_compile_options(knead_options INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion>
    $<$<COMPILE_LANGUAGE:CXX>:-fno-math-errno -fno-trapping-math>
    $<$<COMPILE_LANGUAGE:CUDA>:--expt-relaxed-constexpr --extended-lambda -lineinfo>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Of vectors wider than the processor's GCC says how they are passed; none leaves the program.
    target_compile_options(knead_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-psabi>)
    if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
        # GCC 12 sees overlapping copies in std::string's operator+ (its bug 105651).
        target_compile_options(knead_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>)
    else()
        # GCC 13 takes a reference that a function returns for one to the text that it was given.
        target_compile_options(knead_options INTERFACE
            $<$<COMPILE_LANGUAGE:CXX>:-Wno-dangling-reference>)
    endif()
endif()
if(KNEAD_WERROR)
    target_compile_options(knead_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Werror>
        $<$<COMPILE_LANGUAGE:CUDA>:-Werror=all-warnings>)
endif()
if(KNEAD_VERIFY)
    target_compile_options(knead_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>
        $<$<COMPILE_LANGUAGE:CUDA>:--fmad=false>)
    target_compile_definitions(knead_options INTERFACE KNEAD_VERIFY=1)
elseif(KNEAD_NATIVE)
    target_compile_options(knead_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-march=native>)
endif()
if(KNEAD_COVERAGE)
    target_compile_options(knead_options INTERFACE
        $<$<COMPILE_LANGUAGE:CXX>:-O1 --coverage>)
    target_link_options(knead_options INTERFACE --coverage)
endif()
if(KNEAD_FUZZ)
    set(KNEAD_SANITIZE ON)
    if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
        target_compile_options(knead_options INTERFACE -fsanitize=fuzzer-no-link)
    endif()
endif()
if(KNEAD_SANITIZE)
    target_compile_options(knead_options INTERFACE
        $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=address,undefined -fno-sanitize-recover=undefined>
        $<$<COMPILE_LANGUAGE:CXX>:-g1>)  # functions and lines: all that a finding names
    target_link_options(knead_options INTERFACE -fsanitize=address,undefined)
endif()
if(KNEAD_STATIC)
    list(PREPEND CMAKE_FIND_LIBRARY_SUFFIXES .a)
    target_link_options(knead_options INTERFACE -static-libstdc++ -static-libgcc)
endif()
