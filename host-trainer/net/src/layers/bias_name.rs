//! Names of biases in a layout.

/// Name of the bias that goes with the weights of this name.
pub fn bias_name(weights: &str) -> String {
    format!("{weights} bias")
}
