// The 26 joints of each hand, out of the recording.
#include <algorithm>

#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

XrResult XRAPI_CALL create(XrSession handle, const XrHandTrackerCreateInfoEXT* info,
                           XrHandTrackerEXT* to)
{
    return answered("xrCreateHandTrackerEXT", [&](Runtime& r) {
        session_of(handle);
        check_struct(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT,
                     {XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT});
        refuse_if(info->hand != XR_HAND_LEFT_EXT && info->hand != XR_HAND_RIGHT_EXT,
                  XR_ERROR_VALIDATION_FAILURE, "not a hand");
        refuse_if(info->handJointSet != XR_HAND_JOINT_SET_DEFAULT_EXT, XR_ERROR_VALIDATION_FAILURE,
                  "not the default set of joints");
        auto made = std::make_unique<HandObject>();
        made->side = info->hand == XR_HAND_LEFT_EXT ? left : right;
        if (in_chain(info, XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT)) {
            check_enabled("XR_EXT_hand_tracking_data_source");
            made->sources = true;
        }
        *to = r.add<XrHandTrackerEXT>(std::move(made), number_of(handle));
    });
}

XrResult XRAPI_CALL destroy(XrHandTrackerEXT handle)
{
    return answered("xrDestroyHandTrackerEXT", [&](Runtime& r) {
        r.get<HandObject>(handle);
        r.remove(number_of(handle));
    });
}

void fill(XrHandJointLocationEXT& to, const HandAnswer& from, int joint)
{
    to = {};
    if (!from.active) return;
    to.radius = from.hand.radius[std::size_t(joint)];
    if (!from.hand.valid[std::size_t(joint)]) return;
    const auto& [q, p] = from.hand.joints[std::size_t(joint)];
    to.pose = {{q.x, q.y, q.z, q.w}, {p.x, p.y, p.z}};
    to.locationFlags =
        XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT |
        XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
}

// Moves a joint from LOCAL to where it is in a space.
void place(XrHandJointLocationEXT& joint, const SpaceObject& base, double time)
{
    if (is_plain(base)) {
        joint.pose.position.y += float(higher_in(base));
        return;
    }
    const auto& [q, p] = joint.pose;
    Joint<double> found{{q.w, q.x, q.y, q.z}, {p.x, p.y, p.z}};
    if (joint.locationFlags == 0) return;
    if (in_space(base, time, found))
        joint.pose = pose_of(found);
    else
        joint.locationFlags = 0;
}

XrResult XRAPI_CALL locate(XrHandTrackerEXT handle, const XrHandJointsLocateInfoEXT* info,
                           XrHandJointLocationsEXT* to)
{
    return answered("xrLocateHandJointsEXT", [&](Runtime& r) {
        const HandObject& hand = r.get<HandObject>(handle);
        const SessionObject& session = session_of(reinterpret_cast<XrSession>(hand.parent));
        check_struct(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
        check_struct(
            to, XR_TYPE_HAND_JOINT_LOCATIONS_EXT,
            {XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT, XR_TYPE_HAND_JOINT_VELOCITIES_EXT});
        const SpaceObject& base = r.get<SpaceObject>(info->baseSpace);
        refuse_if(info->time <= 0, XR_ERROR_TIME_INVALID, "not a time");
        refuse_if(to->jointCount != XR_HAND_JOINT_COUNT_EXT || !to->jointLocations,
                  XR_ERROR_VALIDATION_FAILURE, "not 26 joints");
        auto* velocities =
            static_cast<XrHandJointVelocitiesEXT*>(in_chain(to, XR_TYPE_HAND_JOINT_VELOCITIES_EXT));
        refuse_if(velocities && (velocities->jointCount != XR_HAND_JOINT_COUNT_EXT ||
                                 !velocities->jointVelocities),
                  XR_ERROR_VALIDATION_FAILURE, "not 26 velocities");
        HandAnswer answer = hand_at(r.script, hand.side, r.script_time(info->time));
        answer.active = answer.active && session.flow.focused();
        to->isActive = answer.active;
        for (int j = 0; j < joint_count; ++j) {
            fill(to->jointLocations[j], answer, j);
            place(to->jointLocations[j], base, r.script_time(info->time));
        }
        // Velocities are optional: none are given.
        if (velocities)
            std::fill_n(velocities->jointVelocities, joint_count, XrHandJointVelocityEXT{});
        if (void* source = in_chain(to, XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT)) {
            refuse_if(!hand.sources, XR_ERROR_VALIDATION_FAILURE,
                      "the source of a tracker made without sources");
            auto& state = *static_cast<XrHandTrackingDataSourceStateEXT*>(source);
            state.isActive = answer.active;
            state.dataSource = XR_HAND_TRACKING_DATA_SOURCE_UNOBSTRUCTED_EXT;
        }
    });
}

}  // namespace

void add_hand_functions(Table& to)
{
    to["xrCreateHandTrackerEXT"] = entry(create);
    to["xrDestroyHandTrackerEXT"] = entry(destroy);
    to["xrLocateHandJointsEXT"] = entry(locate);
}

}  // namespace knead::replay
