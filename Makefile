.PHONY: demo test
demo test:
	@bash run.sh $@
