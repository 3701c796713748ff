//! What an operator can command in flight.

/// A command of the operator to a node in flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OperatorCommand {
    /// Take control of the vehicle (again), bring it up if need be, and fly the mission.
    Start,
    /// Release control: no more setpoints.
    Release,
    /// Command the return to launch.
    Return,
    /// Release control and command a landing at the present position.
    Land,
}
