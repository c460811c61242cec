"""Which effects cause the gap: candidates screened, fitted, ranked, and weighed against chance and against decoys."""
