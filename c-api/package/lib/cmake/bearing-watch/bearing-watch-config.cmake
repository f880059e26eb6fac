# Defines bearing-watch::bearing-watch. BEARING_WATCH_TARGET names a folder of lib/ where the system does not.
set(_bearing_watch_system)
if(NOT BEARING_WATCH_TARGET)
    if(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "@PROCESSOR@")
        set(BEARING_WATCH_TARGET @HOST@)
    elseif(CMAKE_SYSTEM_NAME STREQUAL "Generic")
        set(BEARING_WATCH_TARGET @CHIP@)
    endif()
endif()
if(BEARING_WATCH_TARGET STREQUAL "@HOST@")
    set(_bearing_watch_system @SYSTEM@)
endif()
get_filename_component(_bearing_watch_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(_bearing_watch_file "${_bearing_watch_prefix}/lib/${BEARING_WATCH_TARGET}/libbearing_watch_c.a")
if(NOT BEARING_WATCH_TARGET OR NOT EXISTS "${_bearing_watch_file}")
    set(bearing-watch_FOUND FALSE)
    set(bearing-watch_NOT_FOUND_MESSAGE
        "no library for ${CMAKE_SYSTEM_NAME} on ${CMAKE_SYSTEM_PROCESSOR}; there are @HOST@ and @CHIP@")
elseif(NOT TARGET bearing-watch::bearing-watch)
    add_library(bearing-watch::bearing-watch STATIC IMPORTED)
    set_target_properties(bearing-watch::bearing-watch PROPERTIES
        IMPORTED_LOCATION "${_bearing_watch_file}"
        INTERFACE_INCLUDE_DIRECTORIES "${_bearing_watch_prefix}/include"
        INTERFACE_LINK_LIBRARIES "${_bearing_watch_system}")
endif()
unset(_bearing_watch_prefix)
unset(_bearing_watch_file)
unset(_bearing_watch_system)
