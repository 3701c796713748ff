"""The acceptance suite: Covey's node beside real autopilot firmware, held to what the documents say."""
