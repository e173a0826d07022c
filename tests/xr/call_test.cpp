// Calls into OpenXR whose function the runtime does not have; advice where one fails.
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "host/base/outputs.h"
#include "tests/folder.h"
#include "xr/advice.h"
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

// Sets a variable for the rest of a test.
struct Variable {
    Variable(const char* of, const std::string& value) : name(of)
    {
        if (const char* const now = std::getenv(of)) before = now;
        setenv(of, value.c_str(), 1);
    }
    ~Variable() { before ? setenv(name, before->c_str(), 1) : unsetenv(name); }
    const char* name;
    std::optional<std::string> before;
};

TEST(Advice, is_to_start_a_runtime_unless_a_layer_is_missing)
{
    const Folder folder;
    write_whole(folder / "monado.json", R"({"runtime": {"name": "Monado"}})");
    const Variable runtime("XR_RUNTIME_JSON", folder / "monado.json");
    const Variable layers("XR_ENABLE_API_LAYERS", "XR_APILAYER_one:XR_APILAYER_two");
    EXPECT_EQ(start_advice(), "start monado-service");
    EXPECT_EQ(start_advice(XR_ERROR_RUNTIME_FAILURE), "start monado-service");
    EXPECT_EQ(start_advice(XR_ERROR_API_LAYER_NOT_PRESENT),
              "install the layers named in XR_ENABLE_API_LAYERS "
              "(\"XR_APILAYER_one:XR_APILAYER_two\"), or unset it");
}

}  // namespace
}  // namespace knead::xr
