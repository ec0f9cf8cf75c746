namespace omma {}
