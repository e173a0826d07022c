#include "host/session/step_rule.h"

namespace knead {

StepRule::Decision StepRule::after_frame(bool touched, double fastest, double seconds, bool open)
{
    if (touched) return after_contact(seconds, open);
    since_contact += seconds, since_change += seconds;
    const bool settled = since_change >= options.settles_within,
               calm = since_change >= options.soonest && fastest < options.calm_speed && !drag;
    return {false, open && (settled || calm)};
}

StepRule::Decision StepRule::after_contact(double seconds, bool open)
{
    const bool another = since_contact >= options.apart;
    contact_time = open && !another ? contact_time + since_contact + seconds : seconds;
    since_contact = since_change = 0, drag = false;
    if (!open || another) return {true, open};
    if (contact_time < options.longest) return {true, false};
    contact_time = 0;
    return {false, true};  // the next contact begins a step
}

void StepRule::command(bool dragged) { since_change = 0, contact_time = 0, drag = dragged; }

void StepRule::restored() { *this = StepRule(options); }

}  // namespace knead
