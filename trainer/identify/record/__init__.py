"""Records of a ship under helm: read, examined, guessed, and their study."""
