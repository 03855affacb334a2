"""The commands of `flatland`, one module each."""
