// Calls into OpenXR whose function the runtime does not have.
#include <gtest/gtest.h>

#include "xr/check.h"

namespace knead::xr {
namespace {

XrResult XRAPI_CALL refuse_address(XrInstance, const char*, PFN_xrVoidFunction* function)
{
    *function = nullptr;
    return XR_ERROR_INSTANCE_LOST;
}

TEST(Call, throws_where_the_runtime_does_not_have_the_function)
{
    const Source lost{refuse_address, XR_NULL_HANDLE};
    Call<PFN_xrDestroySwapchain> destroy{lost, "xrDestroySwapchain"};
    EXPECT_THROW(destroy(XR_NULL_HANDLE), XrFailure);
}

struct Owner {
    explicit Owner(const Source& from) : destroy(from, "xrDestroySwapchain") {}
    ~Owner() { result = destroy.raw(XR_NULL_HANDLE); }
    Call<PFN_xrDestroySwapchain> destroy;
    static inline XrResult result = XR_SUCCESS;
};

TEST(Call, can_be_made_by_a_destructor_after_the_runtime_was_lost)
{
    const Source lost{refuse_address, XR_NULL_HANDLE};
    {
        Owner owner(lost);
    }
    EXPECT_EQ(Owner::result, XR_ERROR_FUNCTION_UNSUPPORTED);
}

}  // namespace
}  // namespace knead::xr
