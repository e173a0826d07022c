// When steps of the history begin and end: decided after each frame, from what the frame did.
// docs/method/history.md.
#pragma once

namespace knead {

struct StepRuleOptions {
    double calm_speed = 0;      // [m/s]: slower clay is at rest
    double soonest = 0.1;       // a step is not captured sooner after a contact or a command [s]
    double settles_within = 1;  // after the last of these, clay counts as quiet [s of the session]
    double longest = 3;         // of contact without a pause, then a step is captured [s]
    double apart = 0.3;         // without contact is a pause: the next contact is another step [s]
};

class StepRule {
  public:
    explicit StepRule(const StepRuleOptions& by) : options(by) {}
    // If both, the capture comes first.
    struct Decision {
        bool begins = false;    // hands change the clay: a step begins, unless one is open
        bool captures = false;  // the open step is captured now
    };
    // `touched`: a tool pressed or carried clay in the frame; `fastest`: speed of the clay at its
    // end [m/s]; `seconds`: duration of the frame; `open`: whether a step is open.
    Decision after_frame(bool touched, double fastest, double seconds, bool open);
    // A command has begun or changed the open step. `dragged`: of a control that may be dragged on.
    void command(bool dragged = false);
    // The clay was replaced: what it does by itself is no step.
    void restored();

  private:
    Decision after_contact(double seconds, bool open);

    StepRuleOptions options;
    double since_contact = 1e30;  // [s]
    double since_change = 1e30;   // since the last contact or command [s]
    bool drag = false;            // the last of these was a command of a drag
    double contact_time = 0;      // since the contact of the open step began [s]
};

}  // namespace knead
