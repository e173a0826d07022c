// Spaces: where the origin and the grips are.
#include "tests/openxr_replay/actions.h"

namespace knead::replay {
namespace {

XrResult XRAPI_CALL list(XrSession handle, std::uint32_t capacity, std::uint32_t* count,
                         XrReferenceSpaceType* to)
{
    return answered("xrEnumerateReferenceSpaces", [&](Runtime&) {
        session_of(handle);
        return give(std::vector<XrReferenceSpaceType>{XR_REFERENCE_SPACE_TYPE_VIEW,
                                                      XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                      XR_REFERENCE_SPACE_TYPE_STAGE},
                    capacity, count, to);
    });
}

void check_reference(XrReferenceSpaceType type)
{
    refuse_if(type < XR_REFERENCE_SPACE_TYPE_VIEW || type > XR_REFERENCE_SPACE_TYPE_STAGE,
              XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "a space that is not offered");
}

XrResult XRAPI_CALL create_reference(XrSession handle, const XrReferenceSpaceCreateInfo* info,
                                     XrSpace* to)
{
    return answered("xrCreateReferenceSpace", [&](Runtime& r) {
        session_of(handle);
        check_struct(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
        check_pose(info->poseInReferenceSpace);
        check_reference(info->referenceSpaceType);
        auto made = std::make_unique<SpaceObject>();
        made->reference = info->referenceSpaceType;
        made->pose = info->poseInReferenceSpace;
        *to = r.add<XrSpace>(std::move(made), number_of(handle));
    });
}

XrResult XRAPI_CALL create_of_action(XrSession handle, const XrActionSpaceCreateInfo* info,
                                     XrSpace* to)
{
    return answered("xrCreateActionSpace", [&](Runtime& r) {
        session_of(handle);
        check_struct(info, XR_TYPE_ACTION_SPACE_CREATE_INFO);
        check_pose(info->poseInActionSpace);
        const ActionObject& action = r.get<ActionObject>(info->action);
        refuse_if(action.type != XR_ACTION_TYPE_POSE_INPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
                  "an action that is not a pose");
        check_subaction(action, info->subactionPath);
        auto made = std::make_unique<SpaceObject>();
        made->action = info->action;
        made->of = info->subactionPath;
        made->pose = info->poseInActionSpace;
        *to = r.add<XrSpace>(std::move(made), number_of(handle));
    });
}

Joint<double> joint_of(const XrPosef& pose)
{
    const auto& [q, p] = pose;
    return {{q.w, q.x, q.y, q.z}, {p.x, p.y, p.z}};
}
Joint<double> joined(const Joint<double>& a, const Joint<double>& b)
{
    return {unit(a.q * b.q), a.p + rotate(a.q, b.p)};
}
Joint<double> inverse(const Joint<double>& a)
{
    return {conjugate(a.q), rotate(conjugate(a.q), -a.p)};
}

// In LOCAL; false where it is not known.
bool find(const SpaceObject& space, double time, Joint<double>& to)
{
    const Script& script = runtime().script;
    if (space.action) {
        const Controller* held = pointed_by(space, time);
        if (!held) return false;
        to = grip_at(*held, time);
    } else if (space.reference == XR_REFERENCE_SPACE_TYPE_VIEW) {
        to = head_at(script, time);
    } else {
        const bool stage = space.reference == XR_REFERENCE_SPACE_TYPE_STAGE;
        to = {{1, 0, 0, 0}, {0, stage ? -floor_below : 0, 0}};
    }
    to = joined(to, joint_of(space.pose));
    return true;
}

XrResult XRAPI_CALL locate(XrSpace handle, XrSpace base, XrTime time, XrSpaceLocation* to)
{
    return answered("xrLocateSpace", [&](Runtime& r) {
        const SpaceObject& space = r.get<SpaceObject>(handle);
        const SpaceObject& from = r.get<SpaceObject>(base);
        session_of(reinterpret_cast<XrSession>(space.parent));
        check_struct(to, XR_TYPE_SPACE_LOCATION, {XR_TYPE_SPACE_VELOCITY});
        refuse_if(time <= 0, XR_ERROR_TIME_INVALID, "not a time");
        to->locationFlags = 0;
        // Velocities are optional: none are given.
        if (void* velocity = in_chain(to, XR_TYPE_SPACE_VELOCITY))
            *static_cast<XrSpaceVelocity*>(velocity) = {
                XR_TYPE_SPACE_VELOCITY, static_cast<XrSpaceVelocity*>(velocity)->next, 0, {}, {}};
        Joint<double> a, b;
        const double at = r.script_time(time);
        if (!find(space, at, a) || !find(from, at, b)) return;
        to->pose = pose_of(joined(inverse(b), a));
        to->locationFlags =
            XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT |
            XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
    });
}

XrResult XRAPI_CALL bounds(XrSession handle, XrReferenceSpaceType type, XrExtent2Df* to)
{
    return answered("xrGetReferenceSpaceBoundsRect", [&](Runtime&) -> XrResult {
        session_of(handle);
        check_reference(type);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the bounds");
        *to = {0, 0};
        return XR_SPACE_BOUNDS_UNAVAILABLE;
    });
}

XrResult XRAPI_CALL destroy(XrSpace handle)
{
    return answered("xrDestroySpace", [&](Runtime& r) {
        r.get<SpaceObject>(handle);
        r.remove(number_of(handle));
    });
}

}  // namespace

bool is_plain(const SpaceObject& space)
{
    const auto& [q, p] = space.pose;
    return !space.action && space.reference != XR_REFERENCE_SPACE_TYPE_VIEW && q.x == 0 &&
           q.y == 0 && q.z == 0 && q.w == 1 && p.x == 0 && p.y == 0 && p.z == 0;
}

bool in_space(const SpaceObject& space, double time, Joint<double>& place)
{
    if (is_plain(space)) {
        place.p.y += higher_in(space);
        return true;
    }
    Joint<double> origin;
    if (!find(space, time, origin)) return false;
    place = joined(inverse(origin), place);
    return true;
}

void add_space_functions(Table& to)
{
    to["xrEnumerateReferenceSpaces"] = entry(list);
    to["xrCreateReferenceSpace"] = entry(create_reference);
    to["xrCreateActionSpace"] = entry(create_of_action);
    to["xrLocateSpace"] = entry(locate);
    to["xrGetReferenceSpaceBoundsRect"] = entry(bounds);
    to["xrDestroySpace"] = entry(destroy);
}

}  // namespace knead::replay
