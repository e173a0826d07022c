# WebP::WebP, the library of WebP images: not every distribution has its package for CMake.
find_path(WEBP_INCLUDE_DIR webp/decode.h)
find_library(WEBP_LIBRARY webp)
find_library(SHARPYUV_LIBRARY sharpyuv)  # apart from WebP 1.3 on
mark_as_advanced(WEBP_INCLUDE_DIR WEBP_LIBRARY SHARPYUV_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(WebP REQUIRED_VARS WEBP_LIBRARY WEBP_INCLUDE_DIR)
if(WebP_FOUND AND NOT TARGET WebP::WebP)
    add_library(WebP::WebP UNKNOWN IMPORTED)
    set_target_properties(WebP::WebP PROPERTIES IMPORTED_LOCATION ${WEBP_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${WEBP_INCLUDE_DIR})
    if(SHARPYUV_LIBRARY)
        set_target_properties(WebP::WebP PROPERTIES
            INTERFACE_LINK_LIBRARIES ${SHARPYUV_LIBRARY})
    endif()
endif()
