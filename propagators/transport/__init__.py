"""What the schemes that answer a scene directly share: surfaces, ordinates, lights without size."""
