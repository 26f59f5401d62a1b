.PHONY: demo test coverage
demo test coverage:
	@bash run.sh $@
