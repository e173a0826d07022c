// The replay runtime is strict: programs that break OpenXR's rules are refused, counted, and ended
// with a code of their own.
#include <gtest/gtest.h>

#ifdef KNEAD_XR_MISUSE
#include "host/base/child.h"

namespace knead {
namespace {

constexpr int failed_by_wrong_calls = 86;

struct Misuse {
    const char *name, *result;
    int code;
};

class ReplayRuntime : public testing::TestWithParam<Misuse> {};

TEST_P(ReplayRuntime, refuses)
{
    const auto [name, result, code] = GetParam();
    std::string said;
    EXPECT_EQ(
        output_of({"env", "XR_RUNTIME_JSON=" KNEAD_XR_RUNTIME, KNEAD_XR_MISUSE, name}, said, 60),
        code);
    EXPECT_EQ(said, std::string(result) + "\n");
}

INSTANTIATE_TEST_SUITE_P(
    Misuses, ReplayRuntime,
    testing::Values(
        Misuse{"none", "XR_SUCCESS", 0},
        Misuse{"unasked_requirements", "XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING",
               failed_by_wrong_calls},
        Misuse{"begin_frame_first", "XR_ERROR_SESSION_NOT_RUNNING", failed_by_wrong_calls},
        Misuse{"end_before_begin", "XR_ERROR_SESSION_NOT_RUNNING", failed_by_wrong_calls},
        Misuse{"wrong_type", "XR_ERROR_VALIDATION_FAILURE", failed_by_wrong_calls},
        Misuse{"not_enabled", "XR_ERROR_FUNCTION_UNSUPPORTED", 0},
        Misuse{"skewed_space", "XR_ERROR_POSE_INVALID", failed_by_wrong_calls},
        Misuse{"unknown_struct", "XR_SUCCESS", failed_by_wrong_calls},
        Misuse{"twice_the_same_name", "XrResult -44", failed_by_wrong_calls},
        Misuse{"unwaited_image", "XR_ERROR_CALL_ORDER_INVALID", failed_by_wrong_calls},
        Misuse{"strange_format", "XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED", failed_by_wrong_calls},
        Misuse{"pending_gl_error", "XR_ERROR_RUNTIME_FAILURE", failed_by_wrong_calls},
        Misuse{"bad_path", "XR_ERROR_PATH_FORMAT_INVALID", failed_by_wrong_calls},
        Misuse{"leak", "XR_SUCCESS", failed_by_wrong_calls}),
    [](const auto& given) { return given.param.name; });

}  // namespace
}  // namespace knead
#endif
