# Included right after `project` where `crane interfaces` builds a package, which then serves Python alone: C++ messages
# take more than half of the time, and nothing in that environment uses them.
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")

# A few large files compile sooner than many small ones with the same headers; those with the texts of the definitions
# share names and stay apart.
set(CMAKE_UNITY_BUILD ON)
function(keep_descriptions_apart)
  get_target_property(sources ${PROJECT_NAME}__rosidl_generator_c SOURCES)
  list(FILTER sources INCLUDE REGEX "__description\\.c$")
  set_source_files_properties(${sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
cmake_language(DEFER CALL keep_descriptions_apart)
