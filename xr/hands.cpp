#include "xr/hands.h"

#include <cmath>

#include "xr/hand_shape.h"

namespace knead::xr {
namespace {

constexpr XrSpaceLocationFlags both =
    XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
static_assert(int(joint_count) == XR_HAND_JOINT_COUNT_EXT);
static_assert(int(wrist) == XR_HAND_JOINT_WRIST_EXT);
static_assert(int(little_tip) == XR_HAND_JOINT_LITTLE_TIP_EXT);

bool sound(const Joint<float>& joint)
{
    const auto& [q, p] = joint;
    const float square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    return std::isfinite(p.x + p.y + p.z) && square > 0.9f && square < 1.1f;
}

}  // namespace

Joint<float> joint_of(const XrPosef& pose)
{
    const auto& [q, p] = pose;
    return {{q.w, q.x, q.y, q.z}, {p.x, p.y, p.z}};
}

Hand hand_of(const XrHandJointLocationsEXT& found, Side side)
{
    Hand hand;
    for (int j = 0; j < joint_count; ++j) {
        hand.joints[j] = {{1, 0, 0, 0}, {0, 0, 0}};
        const XrHandJointLocationEXT& from = found.jointLocations[j];
        // Some runtimes report isActive although the joints are invalid.
        if (!found.isActive || (from.locationFlags & both) != both) continue;
        const Joint<float> joint = joint_of(from.pose);
        if (!sound(joint)) continue;
        hand.joints[j] = {unit(joint.q), joint.p};
        hand.radius[j] = from.radius;
        hand.valid[j] = true;
    }
    hand.tracked = hand.valid[wrist];
    complete_radii(hand, side);
    return hand;
}

HandTrackers::HandTrackers(Instance& of, XrSession session) : instance(of)
{
    if (!instance.tracks_hands) return;
    for (int side = 0; side < side_count; ++side) {
        auto about = typed<XrHandTrackerCreateInfoEXT>(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
        about.hand = side == left ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
        about.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
        // Accept both: camera tracking, and hands inferred from a controller.
        XrHandTrackingDataSourceEXT wanted[] = {XR_HAND_TRACKING_DATA_SOURCE_UNOBSTRUCTED_EXT,
                                                XR_HAND_TRACKING_DATA_SOURCE_CONTROLLER_EXT};
        const XrHandTrackingDataSourceInfoEXT sources{XR_TYPE_HAND_TRACKING_DATA_SOURCE_INFO_EXT,
                                                      nullptr, 2, wanted};
        if (instance.has[hand_data_source]) about.next = &sources;
        sources_told[side] = instance.has[hand_data_source];
        XrResult result = instance.api.create_hand_tracker.raw(session, &about, &tracker[side]);
        if (XR_FAILED(result) && sources_told[side]) {
            // Retry without data sources: an API layer may not support them.
            about.next = nullptr;
            sources_told[side] = false;
            result = instance.api.create_hand_tracker.raw(session, &about, &tracker[side]);
        }
        if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
            throw XrFailure("xrCreateHandTrackerEXT", result);
        if (XR_FAILED(result)) tracker[side] = XR_NULL_HANDLE;
    }
}

HandTrackers::~HandTrackers()
{
    for (const XrHandTrackerEXT one : tracker)
        if (one) instance.api.destroy_hand_tracker.raw(one);
}

TrackedHand HandTrackers::locate(Side side, XrSpace space, XrTime time)
{
    TrackedHand to;
    if (!tracker[side]) return to;
    auto about = typed<XrHandJointsLocateInfoEXT>(XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    about.baseSpace = space;
    about.time = time;
    XrHandJointLocationEXT joints[XR_HAND_JOINT_COUNT_EXT] = {};
    XrHandTrackingDataSourceStateEXT source{};
    source.type = XR_TYPE_HAND_TRACKING_DATA_SOURCE_STATE_EXT;
    auto found = typed<XrHandJointLocationsEXT>(XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    if (sources_told[side]) found.next = &source;
    found.jointCount = XR_HAND_JOINT_COUNT_EXT;
    found.jointLocations = joints;
    instance.api.locate_hand(tracker[side], &about, &found);
    to.hand = hand_of(found, side);
    const bool inferred = sources_told[side] && source.isActive &&
                          source.dataSource == XR_HAND_TRACKING_DATA_SOURCE_CONTROLLER_EXT;
    if (to.hand.tracked) to.from = inferred ? HandFrom::controller : HandFrom::cameras;
    return to;
}

}  // namespace knead::xr
